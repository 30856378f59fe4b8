/* A machine of one scene: its memory, what goes into it and comes out of it, and the calls of the compiled kernels.

   The memory is one block, described by scene.h; kernels are functions of its address. All that changes stands in `state`
   and in the part of the memory before the log, so a copy of both is the state of a machine. */

#include "machine.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum found { STATE, SEEN, SEEN_WHOLE, BODY, EVENT }; /* as in variables.py */
enum body { POSITION, BODY_VELOCITY = 3, ODOMETRY = 6, ANGULAR_VELOCITY, ORIENTATION = 10, BODY_VALUES = 14 };

struct place {
    enum found found;
    size_t at;
};
struct copy {
    size_t from, to, size;
};
struct factor {
    int parameter;
    size_t at;
    double by;
};
struct follower {
    int input;
    double twist[3];
};

#include "scene.h"

extern const unsigned char omnisim_start[];

enum { INPUT_COUNT = sizeof INPUT / sizeof *INPUT, OUTPUT_COUNT = sizeof OUTPUT / sizeof *OUTPUT, ALIGNMENT = 64 };
#define ON_GRID 1e-9             /* relative, of times that must be multiples of the step */
#define MOST_STEPS 1000000000000 /* in one call */

struct state {
    uint64_t library; /* whose state it is */
    int64_t pieces;   /* of the tables */
    int64_t events[EVENT_KINDS];
    double parameter[PARAMETERS + 1];
};
struct omnisim_machine {
    struct state state;
    int seen, placed; /* whether forces and body are those of this instant */
    double body[BODY_VALUES];
    char message[512];
    unsigned char *memory;
};

static double *reals(const omnisim_machine *machine, size_t at) { return (double *)(machine->memory + at); }
static int64_t *whole(const omnisim_machine *machine, size_t at) { return (int64_t *)(machine->memory + at); }
static uint32_t *piece(const omnisim_machine *machine) { return (uint32_t *)(machine->memory + CLOCK_PIECE); }
static double *inputs(const omnisim_machine *machine, int64_t piece) {
    return reals(machine, INPUTS) + 2 * CHANNELS * piece; /* value and slope of each channel */
}

/* --- what is wrong ------------------------------------------------------------------------------ */

static omnisim_status refused(omnisim_machine *machine, const char *format, const char *name, double a, double b) {
    char number[2][40];
    snprintf(number[0], sizeof number[0], "%.17g", a);
    snprintf(number[1], sizeof number[1], "%.9g", b);
    snprintf(machine->message, sizeof machine->message, format, name, number[0], number[1]);
    return omnisim_REFUSED;
}

/* The sentence of a status: {time}, {wheel}, {rate} and {limit} in it become what they are. */
static omnisim_status explained(omnisim_machine *machine) {
    int64_t status = *whole(machine, CLOCK_STATUS), wheel = *whole(machine, CLOCK_WHEEL);
    double rate = *reals(machine, CLOCK_RATE);
    const char *from = SENTENCE[status];
    char *to = machine->message, *end = to + sizeof machine->message - 64;
    while (*from && to < end) {
        const char *close = *from == '{' ? strchr(from, '}') : NULL;
        if (!close) {
            *to++ = *from++;
            continue;
        }
        if (!strncmp(from, "{time}", 6))
            to += snprintf(to, 32, "%.9g", omnisim_time(machine) + *reals(machine, CLOCK_ELAPSED));
        else if (!strncmp(from, "{wheel}", 7))
            to += snprintf(to, end + 64 - to, "%s", WHEEL[wheel < 0 ? 0 : wheel]);
        else if (!strncmp(from, "{rate}", 6))
            to += snprintf(to, 32, "%.3g", rate);
        else
            to += snprintf(to, 32, "%.2g", rate > 0.0 ? SAFE_STEP * STABILITY_LIMIT / rate : 0.0);
        from = close + 1;
    }
    *to = '\0';
    return omnisim_STOPPED;
}

/* --- marching ----------------------------------------------------------------------------------- */

/* March up to a step of the grid, which is an output row: the energy is weighed there. */
static omnisim_status march(omnisim_machine *machine, int64_t goal) {
    int64_t status;
    machine->seen = machine->placed = 0;
    machine->message[0] = '\0';
    if (goal > 0) {
        *whole(machine, CLOCK_ROW) = 1;
        *whole(machine, CLOCK_STEPS_PER_ROW) = goal;
    }
    *whole(machine, CLOCK_GOAL) = goal;
    do {
        status = CALLED(march)(machine->memory);
        int64_t count = *whole(machine, CLOCK_EVENTS);
        for (int64_t i = 0; i < count; i++)
            machine->state.events[*whole(machine, LOG + i * EVENT_SIZE + EVENT_KIND)]++;
        *whole(machine, CLOCK_EVENTS) = 0;
    } while (status == LOG_FULL);
    return status == RUNNING ? omnisim_RUNNING : explained(machine);
}

/* The start with the parameters as they are. What a parameter changes is proportional to it. */
static omnisim_status begin(omnisim_machine *machine) {
    struct state *state = &machine->state;
    state->library = LIBRARY;
    state->pieces = PIECES;
    memset(state->events, 0, sizeof state->events);
    memcpy(machine->memory, omnisim_start, KEPT);
    for (int i = 0; i < FACTORS; i++) {
        double value = state->parameter[FACTOR[i].parameter];
        if (value != PARAMETER[FACTOR[i].parameter].start)
            *reals(machine, FACTOR[i].at) = FACTOR[i].by * value;
    }
    return march(machine, 0); /* stands the machine on the floor */
}

omnisim_status omnisim_reset(omnisim_machine *machine) {
    for (int i = 0; i < PARAMETERS; i++)
        machine->state.parameter[i] = PARAMETER[i].start;
    return begin(machine);
}

omnisim_status omnisim_set_parameter(omnisim_machine *machine, int parameter, double value) {
    const omnisim_variable *found = omnisim_parameter(parameter);
    if (!found)
        return refused(machine, "%sthere is no parameter %s", "", parameter, 0.0);
    if (!(value >= found->least && value <= found->most)) {
        snprintf(machine->message, sizeof machine->message, "%s must be within %.9g and %.9g, not %.17g", found->name,
                 found->least, found->most, value);
        return omnisim_REFUSED;
    }
    machine->state.parameter[parameter] = value;
    return begin(machine);
}

double omnisim_get_parameter(const omnisim_machine *machine, int parameter) {
    return omnisim_parameter(parameter) ? machine->state.parameter[parameter] : NAN;
}

omnisim_machine *omnisim_open(void) {
    omnisim_machine *machine = calloc(1, sizeof *machine + SIZE + ALIGNMENT);
    if (!machine)
        return NULL;
    uintptr_t first = (uintptr_t)(machine + 1);
    machine->memory = (unsigned char *)((first + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT);
    omnisim_reset(machine);
    return machine;
}

void omnisim_close(omnisim_machine *machine) { free(machine); }

omnisim_status omnisim_step(omnisim_machine *machine, double seconds) {
    double steps = round(seconds / GRID);
    if (!(steps >= 1.0 && steps <= MOST_STEPS && fabs(seconds - steps * GRID) <= ON_GRID * seconds))
        return refused(machine, "%s%s s is no multiple of the scene's time.step, %s s", "", seconds, GRID);
    if (omnisim_stopped(machine))
        return explained(machine);
    return march(machine, *whole(machine, CLOCK_STEP) + (int64_t)steps);
}

/* --- inputs ------------------------------------------------------------------------------------- */

/* The piece of the tables that begins now, made if there is none; what is past makes room. */
static int64_t piece_from_now(omnisim_machine *machine) {
    double *starts = reals(machine, STARTS), now = omnisim_time(machine);
    int64_t past = *piece(machine), next = past + 1, *pieces = &machine->state.pieces;
    if (next < *pieces && starts[next] <= now)
        return next;
    *pieces -= past;
    memmove(starts, starts + past, *pieces * sizeof *starts);
    memmove(inputs(machine, 0), inputs(machine, past), *pieces * 2 * CHANNELS * sizeof(double));
    memmove(starts + 2, starts + 1, (*pieces - 1) * sizeof *starts);
    memmove(inputs(machine, 2), inputs(machine, 1), (*pieces - 1) * 2 * CHANNELS * sizeof(double));
    for (int i = 0; i < CHANNELS; i++) {
        double value = inputs(machine, 0)[2 * i], slope = inputs(machine, 0)[2 * i + 1];
        inputs(machine, 1)[2 * i] = value + slope * (now - starts[0]);
        inputs(machine, 1)[2 * i + 1] = slope;
    }
    starts[1] = now;
    *piece(machine) = 0;
    ++*pieces;
    for (int64_t i = *pieces; i < PIECES_ROOM; i++)
        starts[i] = INFINITY; /* never begins */
    return 1;
}

omnisim_status omnisim_set(omnisim_machine *machine, int input, double value) {
    if (!omnisim_input(input))
        return refused(machine, "%sthere is no input %s", "", input, 0.0);
    if (!isfinite(value))
        return refused(machine, "%s must be a finite number, not %s", INPUT[input].name, value, 0.0);
    machine->message[0] = '\0';
    for (int64_t i = piece_from_now(machine); i < machine->state.pieces; i++) {
        inputs(machine, i)[2 * CHANNEL[input]] = value;
        inputs(machine, i)[2 * CHANNEL[input] + 1] = 0.0;
    }
    if (strncmp(INPUT[input].name, "wrench/", 7) == 0)
        *whole(machine, PUSHED) = 1;
    return omnisim_RUNNING;
}

omnisim_status omnisim_command(omnisim_machine *machine, double vx, double vy, double yaw_rate) {
    if (FOLLOWERS == 0)
        return refused(machine, "%sno wheel has a drive that follows a rate, which could follow a command", "", 0, 0);
    if (!isfinite(vx + vy + yaw_rate))
        return refused(machine, "%sa command must be three finite numbers", "", 0.0, 0.0);
    for (int i = 0; i < FOLLOWERS; i++) {
        const double *by = FOLLOWER[i].twist;
        omnisim_set(machine, FOLLOWER[i].input, by[0] * vx + by[1] * vy + by[2] * yaw_rate);
    }
    return omnisim_RUNNING;
}

/* --- outputs ------------------------------------------------------------------------------------ */

static void turn(const double rotation[3][3], const double *vector, double *turned) {
    for (int i = 0; i < 3; i++)
        turned[i] = rotation[i][0] * vector[0] + rotation[i][1] * vector[1] + rotation[i][2] * vector[2];
}

/* Of the chassis origin or the centre of a bare wheel, from the centre of mass; arm: from this to that. */
static void find_body(omnisim_machine *machine, const double *y) {
    double *body = machine->body, arm[3] = {0.0, 0.0, HEIGHT}, rate[3] = {0.0, 0.0, y[YAW_RATE]};
    double origin[3] = {y[0], y[1], 0.0}, velocity[3] = {y[VELOCITY], y[VELOCITY + 1], 0.0};
#if FREE
    double norm = sqrt(y[3] * y[3] + y[4] * y[4] + y[5] * y[5] + y[6] * y[6]), *q = body + ORIENTATION;
    for (int i = 0; i < 4; i++)
        q[i] = y[3 + i] / norm;
    const double rotation[3][3] = {
        {1 - 2 * (q[2] * q[2] + q[3] * q[3]), 2 * (q[1] * q[2] - q[0] * q[3]), 2 * (q[1] * q[3] + q[0] * q[2])},
        {2 * (q[1] * q[2] + q[0] * q[3]), 1 - 2 * (q[1] * q[1] + q[3] * q[3]), 2 * (q[2] * q[3] - q[0] * q[1])},
        {2 * (q[1] * q[3] - q[0] * q[2]), 2 * (q[2] * q[3] + q[0] * q[1]), 1 - 2 * (q[1] * q[1] + q[2] * q[2])}};
    turn(rotation, reals(machine, ORIGIN), arm);
    turn(rotation, y + RATE, rate);
    memcpy(body + ANGULAR_VELOCITY, rate, sizeof rate);
    origin[2] = y[2];
    velocity[2] = y[VELOCITY + 2];
#else
    const double *centre = reals(machine, CENTRE), c = cos(y[2]), s = sin(y[2]);
    arm[0] = -(centre[0] * c - centre[1] * s);
    arm[1] = -(centre[0] * s + centre[1] * c);
    (void)turn;
#endif
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3, k = (i + 2) % 3;
        body[POSITION + i] = origin[i] + arm[i];
        body[BODY_VELOCITY + i] = velocity[i] + (FREE || i < 2 ? rate[j] * arm[k] - rate[k] * arm[j] : 0.0);
    }
    body[ODOMETRY] = *reals(machine, ODOMETRY_YAW);
    for (int w = 0; w < WHEELS; w++)
        body[ODOMETRY] += reals(machine, WHEEL_ODOMETRY + w * WHEEL_SIZE)[2] * y[SPIN_ANGLE + w];
    machine->placed = 1;
}

static void look(omnisim_machine *machine) {
    for (size_t i = 0; i < sizeof COPIED / sizeof *COPIED; i++)
        memcpy(machine->memory + COPIED[i].to, machine->memory + COPIED[i].from, COPIED[i].size);
    memcpy(machine->memory + SEEN_PIECE, piece(machine), sizeof *piece(machine));
    *reals(machine, SEEN_TIME) = omnisim_time(machine);
    CALLED(observe)(machine->memory);
    machine->seen = 1;
}

double omnisim_get(omnisim_machine *machine, int output) {
    if (!omnisim_output(output))
        return NAN;
    const struct place *place = &PLACE[output];
    if (place->found == STATE)
        return *reals(machine, place->at);
    if (place->found == EVENT)
        return (double)machine->state.events[place->at];
    if (place->found == BODY) {
        if (!machine->placed)
            find_body(machine, reals(machine, Y));
        return machine->body[place->at];
    }
    if (!machine->seen)
        look(machine);
    return place->found == SEEN ? *reals(machine, place->at) : (double)*whole(machine, place->at);
}

/* --- the state ---------------------------------------------------------------------------------- */

size_t omnisim_state_size(void) { return sizeof(struct state) + KEPT; }

void omnisim_save(const omnisim_machine *machine, void *state) {
    memcpy(state, &machine->state, sizeof machine->state);
    memcpy((unsigned char *)state + sizeof machine->state, machine->memory, KEPT);
}

omnisim_status omnisim_restore(omnisim_machine *machine, const void *state) {
    uint64_t library;
    memcpy(&library, state, sizeof library);
    if (library != LIBRARY)
        return refused(machine, "%sthis is no state of a machine of this library", "", 0.0, 0.0);
    memcpy(&machine->state, state, sizeof machine->state);
    memcpy(machine->memory, (const unsigned char *)state + sizeof machine->state, KEPT);
    machine->seen = machine->placed = 0;
    machine->message[0] = '\0';
    return omnisim_stopped(machine) ? explained(machine) : omnisim_RUNNING;
}

/* --- what there is ------------------------------------------------------------------------------ */

static int find(const omnisim_variable *variables, int count, const char *name) {
    for (int i = 0; i < count; i++)
        if (!strcmp(variables[i].name, name))
            return i;
    return -1;
}

int omnisim_find_input(const char *name) { return find(INPUT, INPUT_COUNT, name); }
int omnisim_find_output(const char *name) { return find(OUTPUT, OUTPUT_COUNT, name); }
int omnisim_find_parameter(const char *name) { return find(PARAMETER, PARAMETERS, name); }
const omnisim_variable *omnisim_input(int i) { return i >= 0 && i < INPUT_COUNT ? &INPUT[i] : NULL; }
const omnisim_variable *omnisim_output(int i) { return i >= 0 && i < OUTPUT_COUNT ? &OUTPUT[i] : NULL; }
const omnisim_variable *omnisim_parameter(int i) { return i >= 0 && i < PARAMETERS ? &PARAMETER[i] : NULL; }
double omnisim_grid(void) { return GRID; }
double omnisim_end(void) { return END; }
double omnisim_time(const omnisim_machine *machine) { return (double)*whole(machine, CLOCK_STEP) * GRID; }
const char *omnisim_message(const omnisim_machine *machine) { return machine->message; }
int omnisim_stopped(const omnisim_machine *machine) { return *whole(machine, CLOCK_STATUS) != RUNNING; }
