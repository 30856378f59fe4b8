/* What FMI 2.0 and 3.0 have in common: an instance, its variables and its states. Included by fmi2.c or fmi3.c alone.

   Value references: 0 is time; then inputs, outputs and parameters, in the order of machine.h. */

#include "machine.h"
#include "variables.h" /* INPUTS, OUTPUTS, PARAMETERS, TOKEN: written by omnisim */

#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EXPORTED __attribute__((visibility("default")))

enum { OK, WARNING, DISCARD, ERROR, FATAL }; /* the same in both standards */

struct told {
    double start;        /* time at which the importer began, s */
    int begun;           /* initialization is over */
    double input[INPUTS]; /* what the importer has said last */
    int given[INPUTS];   /* and whether that is in the place of what the scene gives */
};
struct instance {
    omnisim_machine *machine;
    struct told told;
    void *environment;
    void (*log)(void); /* the importer's, of the type that the standard says */
    int logging;
    char name[];
};

static void tell(struct instance *instance, int status, const char *message); /* to the importer's log */

/* Tell why, if all is not well; the status. */
static int complain(struct instance *instance, int status, const char *format, ...) {
    char message[600];
    va_list values;
    va_start(values, format);
    vsnprintf(message, sizeof message, format, values);
    va_end(values);
    if (instance->log && (instance->logging || status >= DISCARD))
        tell(instance, status, message);
    return status;
}

/* What a machine returns, as a status of FMI: what is refused may be tried again, what is stopped is at its end. */
static int status_of(struct instance *instance, omnisim_status status) {
    if (status == omnisim_RUNNING)
        return OK;
    return complain(instance, status == omnisim_REFUSED ? DISCARD : ERROR, "%s", omnisim_message(instance->machine));
}

static void begin(struct instance *instance) {
    memset(&instance->told, 0, sizeof instance->told);
    for (int i = 0; i < INPUTS; i++)
        instance->told.input[i] = omnisim_input(i)->start;
}

static struct instance *instantiate(const char *name, const char *token, void *environment, void (*log)(void),
                                    int logging) {
    struct instance *instance = calloc(1, sizeof *instance + strlen(name) + 1);
    if (!instance)
        return NULL;
    strcpy(instance->name, name);
    instance->environment = environment;
    instance->log = log;
    instance->logging = logging;
    if (!token || strcmp(token, TOKEN))
        complain(instance, ERROR, "the token is %s, not that of this machine, %s", token ? token : "missing", TOKEN);
    else if (!(instance->machine = omnisim_open()))
        complain(instance, ERROR, "no memory for a machine");
    begin(instance);
    if (instance->machine)
        return instance;
    free(instance);
    return NULL;
}

static void release(struct instance *instance) {
    if (instance)
        omnisim_close(instance->machine);
    free(instance);
}

static int reset(struct instance *instance) {
    begin(instance);
    return status_of(instance, omnisim_reset(instance->machine));
}

static int set_logging(struct instance *instance, int on) {
    instance->logging = on;
    return OK;
}

/* Initialization, from the time at which the importer begins to its end. */
static int start_at(struct instance *instance, double start) {
    instance->told.start = start;
    return OK;
}

static int end_initialization(struct instance *instance) {
    instance->told.begun = 1;
    return OK;
}

static double now(const struct instance *instance) { return instance->told.start + omnisim_time(instance->machine); }

static int get(struct instance *instance, uint32_t reference, double *value) {
    if (reference == 0)
        *value = now(instance);
    else if (reference <= INPUTS)
        *value = instance->told.input[reference - 1];
    else if (reference <= INPUTS + OUTPUTS)
        *value = omnisim_get(instance->machine, (int)(reference - 1 - INPUTS));
    else if (reference <= INPUTS + OUTPUTS + PARAMETERS)
        *value = omnisim_get_parameter(instance->machine, (int)(reference - 1 - INPUTS - OUTPUTS));
    else
        return complain(instance, ERROR, "there is no variable with value reference %u", (unsigned)reference);
    return OK;
}

/* A parameter takes the machine back to its start, with the inputs that are set already. */
static int set_parameter(struct instance *instance, int parameter, double value) {
    if (instance->told.begun)
        return complain(instance, DISCARD, "%s is fixed after initialization", omnisim_parameter(parameter)->name);
    int status = status_of(instance, omnisim_set_parameter(instance->machine, parameter, value));
    for (int i = 0; i < INPUTS && status == OK; i++)
        if (instance->told.given[i])
            status = status_of(instance, omnisim_set(instance->machine, i, instance->told.input[i]));
    return status;
}

/* An input acts from when it is set to something new, and after initialization from when it is set at all: importers may
   set start values, and these leave to a drive what the scene gives it. */
static int set(struct instance *instance, uint32_t reference, double value) {
    if (reference > INPUTS + OUTPUTS && reference <= INPUTS + OUTPUTS + PARAMETERS)
        return set_parameter(instance, (int)(reference - 1 - INPUTS - OUTPUTS), value);
    if (reference < 1 || reference > INPUTS)
        return complain(instance, ERROR, "there is no input or parameter with value reference %u", (unsigned)reference);
    struct told *told = &instance->told;
    int i = (int)reference - 1;
    if (value == told->input[i] && (told->given[i] || !told->begun))
        return OK;
    int status = status_of(instance, omnisim_set(instance->machine, i, value));
    if (status == OK) {
        told->input[i] = value;
        told->given[i] = 1;
    }
    return status;
}

static int get_reals(struct instance *instance, const uint32_t references[], size_t count, double values[]) {
    int status = OK;
    for (size_t i = 0; i < count && status == OK; i++)
        status = get(instance, references[i], &values[i]);
    return status;
}

static int set_reals(struct instance *instance, const uint32_t references[], size_t count, const double values[]) {
    int status = OK;
    for (size_t i = 0; i < count && status == OK; i++)
        status = set(instance, references[i], values[i]);
    return status;
}

static int step(struct instance *instance, double point, double length) {
    if (!(fabs(point - now(instance)) < 0.5 * omnisim_grid()))
        return complain(instance, DISCARD, "the machine is at t = %.9g s, not at %.9g s", now(instance), point);
    return status_of(instance, omnisim_step(instance->machine, length));
}

/* --- states: what was told, then that of the machine ---------------------------------------------- */

static size_t state_size(void) { return sizeof(struct told) + omnisim_state_size(); }

static int save(struct instance *instance, void **state) {
    if (!*state && !(*state = malloc(state_size())))
        return complain(instance, ERROR, "no memory for a state");
    memcpy(*state, &instance->told, sizeof instance->told);
    omnisim_save(instance->machine, (unsigned char *)*state + sizeof instance->told);
    return OK;
}

static int restore(struct instance *instance, const void *state) {
    if (!state)
        return complain(instance, ERROR, "there is no such state");
    omnisim_status status = omnisim_restore(instance->machine, (const unsigned char *)state + sizeof instance->told);
    if (status != omnisim_REFUSED)
        memcpy(&instance->told, state, sizeof instance->told);
    return status == omnisim_REFUSED ? status_of(instance, status) : OK;
}

static int forget(void **state) {
    free(*state);
    *state = NULL;
    return OK;
}

static int measure(size_t *size) {
    *size = state_size();
    return OK;
}

static int pack(struct instance *instance, const void *state, void *bytes, size_t size) {
    if (size < state_size())
        return complain(instance, ERROR, "a state of this machine has %zu bytes, not %zu", state_size(), size);
    memcpy(bytes, state, state_size());
    return OK;
}

static int unpack(struct instance *instance, const void *bytes, size_t size, void **state) {
    if (size != state_size())
        return complain(instance, ERROR, "a state of this machine has %zu bytes, not %zu", state_size(), size);
    if (!(*state = malloc(size)))
        return complain(instance, ERROR, "no memory for a state");
    memcpy(*state, bytes, size);
    return OK;
}
