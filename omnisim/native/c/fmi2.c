/* A machine as FMI 2.0 for Co-Simulation has it. */

#include "fmi.h"

typedef void (*log_message)(void *environment, const char *name, int status, const char *category, const char *message,
                            ...);
struct callbacks {
    log_message log;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
};
enum { STEP_STATUS, PENDING, LAST_TIME, TERMINATED }; /* what importers ask of a step */

static void tell(struct instance *instance, int status, const char *message) {
    ((log_message)instance->log)(instance->environment, instance->name, status, "logStatusError", "%s", message);
}

EXPORTED const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORTED const char *fmi2GetVersion(void) { return "2.0"; }

EXPORTED void *fmi2Instantiate(const char *name, int kind, const char *token, const char *resources,
                               const struct callbacks *callbacks, int visible, int logging) {
    (void)resources, (void)visible;
    if (kind != 1) /* Co-Simulation */
        return NULL;
    void (*log)(void) = callbacks ? (void (*)(void))callbacks->log : NULL;
    return instantiate(name ? name : "", token, callbacks ? callbacks->environment : NULL, log, logging);
}

EXPORTED void fmi2FreeInstance(struct instance *instance) { release(instance); }
EXPORTED int fmi2Reset(struct instance *instance) { return reset(instance); }
EXPORTED int fmi2Terminate(struct instance *instance) { return instance ? OK : ERROR; }

EXPORTED int fmi2SetDebugLogging(struct instance *instance, int on, size_t count, const char *const categories[]) {
    (void)count, (void)categories;
    return set_logging(instance, on);
}

EXPORTED int fmi2SetupExperiment(struct instance *instance, int tolerated, double tolerance, double start, int limited,
                                 double stop) {
    (void)tolerated, (void)tolerance, (void)limited, (void)stop;
    return start_at(instance, start);
}

EXPORTED int fmi2EnterInitializationMode(struct instance *instance) { return instance ? OK : ERROR; }

EXPORTED int fmi2ExitInitializationMode(struct instance *instance) { return end_initialization(instance); }

/* A machine that is stopped discards the rest of the step: where it stands, fmi2GetRealStatus tells. */
EXPORTED int fmi2DoStep(struct instance *instance, double point, double length, int final) {
    (void)final;
    int status = step(instance, point, length);
    return status == ERROR ? DISCARD : status;
}

EXPORTED int fmi2GetRealStatus(struct instance *instance, int kind, double *value) {
    *value = now(instance);
    return kind == LAST_TIME ? OK : DISCARD;
}

EXPORTED int fmi2GetBooleanStatus(struct instance *instance, int kind, int *value) {
    *value = omnisim_stopped(instance->machine);
    return kind == TERMINATED ? OK : DISCARD;
}

/* --- variables ------------------------------------------------------------------------------------ */

EXPORTED int fmi2GetReal(struct instance *instance, const uint32_t references[], size_t count, double values[]) {
    return get_reals(instance, references, count, values);
}

EXPORTED int fmi2GetInteger(struct instance *instance, const uint32_t references[], size_t count, int values[]) {
    int status = OK;
    for (size_t i = 0; i < count && status == OK; i++) {
        double value = 0.0;
        status = get(instance, references[i], &value);
        values[i] = (int)value;
    }
    return status;
}

EXPORTED int fmi2SetReal(struct instance *instance, const uint32_t references[], size_t count, const double values[]) {
    return set_reals(instance, references, count, values);
}

/* --- states --------------------------------------------------------------------------------------- */

EXPORTED int fmi2GetFMUstate(struct instance *instance, void **state) { return save(instance, state); }
EXPORTED int fmi2SetFMUstate(struct instance *instance, void *state) { return restore(instance, state); }

EXPORTED int fmi2FreeFMUstate(struct instance *instance, void **state) {
    (void)instance;
    return forget(state);
}

EXPORTED int fmi2SerializedFMUstateSize(struct instance *instance, void *state, size_t *size) {
    (void)instance, (void)state;
    return measure(size);
}

EXPORTED int fmi2SerializeFMUstate(struct instance *instance, void *state, unsigned char bytes[], size_t size) {
    return pack(instance, state, bytes, size);
}

EXPORTED int fmi2DeSerializeFMUstate(struct instance *instance, const unsigned char bytes[], size_t size, void **state) {
    return unpack(instance, bytes, size, state);
}

/* --- what a machine does not have ------------------------------------------------------------------ */

#define ABSENT(function)                                                                                                \
    EXPORTED int function(struct instance *instance) {                                                                  \
        return complain(instance, ERROR, "a machine for Co-Simulation has no %s", #function);                           \
    }
ABSENT(fmi2GetBoolean)
ABSENT(fmi2GetString)
ABSENT(fmi2SetInteger)
ABSENT(fmi2SetBoolean)
ABSENT(fmi2SetString)
ABSENT(fmi2GetDirectionalDerivative)
ABSENT(fmi2SetRealInputDerivatives)
ABSENT(fmi2GetRealOutputDerivatives)
ABSENT(fmi2CancelStep)
ABSENT(fmi2GetStatus)
ABSENT(fmi2GetIntegerStatus)
ABSENT(fmi2GetStringStatus)
