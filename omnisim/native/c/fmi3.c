/* A machine as FMI 3.0 for Co-Simulation has it. What the standard asks for and a machine does not have is refused. */

#include "fmi.h"

#include <stdbool.h>

typedef void (*log_message)(void *environment, int status, const char *category, const char *message);

static void tell(struct instance *instance, int status, const char *message) {
    ((log_message)instance->log)(instance->environment, status, "logStatusError", message);
}

EXPORTED const char *fmi3GetVersion(void) { return "3.0"; }

EXPORTED void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *resources, bool visible,
                                           bool logging, bool events, bool early, const uint32_t intermediate[],
                                           size_t count, void *environment, log_message log, void (*update)(void)) {
    (void)resources, (void)visible, (void)events, (void)early, (void)intermediate, (void)count, (void)update;
    return instantiate(name ? name : "", token, environment, (void (*)(void))log, logging);
}

EXPORTED void fmi3FreeInstance(struct instance *instance) { release(instance); }
EXPORTED int fmi3Reset(struct instance *instance) { return reset(instance); }
EXPORTED int fmi3Terminate(struct instance *instance) { return instance ? OK : ERROR; }

EXPORTED int fmi3SetDebugLogging(struct instance *instance, bool on, size_t count, const char *const categories[]) {
    (void)count, (void)categories;
    return set_logging(instance, on);
}

EXPORTED int fmi3EnterInitializationMode(struct instance *instance, bool tolerated, double tolerance, double start,
                                         bool limited, double stop) {
    (void)tolerated, (void)tolerance, (void)limited, (void)stop;
    return start_at(instance, start);
}

EXPORTED int fmi3ExitInitializationMode(struct instance *instance) { return end_initialization(instance); }

EXPORTED int fmi3DoStep(struct instance *instance, double point, double length, bool final, bool *event, bool *terminate,
                        bool *early, double *last) {
    (void)final;
    int status = step(instance, point, length);
    *event = *early = false;
    *terminate = status == ERROR;
    *last = now(instance);
    return status;
}

/* --- variables ------------------------------------------------------------------------------------ */

static int scalars(struct instance *instance, size_t count, size_t size) {
    return count == size ? OK : complain(instance, ERROR, "variables are no arrays");
}

EXPORTED int fmi3GetFloat64(struct instance *instance, const uint32_t references[], size_t count, double values[],
                            size_t size) {
    int status = scalars(instance, count, size);
    return status == OK ? get_reals(instance, references, count, values) : status;
}

EXPORTED int fmi3GetInt64(struct instance *instance, const uint32_t references[], size_t count, int64_t values[],
                          size_t size) {
    int status = scalars(instance, count, size);
    for (size_t i = 0; i < count && status == OK; i++) {
        double value = 0.0;
        status = get(instance, references[i], &value);
        values[i] = (int64_t)value;
    }
    return status;
}

EXPORTED int fmi3SetFloat64(struct instance *instance, const uint32_t references[], size_t count, const double values[],
                            size_t size) {
    int status = scalars(instance, count, size);
    return status == OK ? set_reals(instance, references, count, values) : status;
}

/* --- states --------------------------------------------------------------------------------------- */

EXPORTED int fmi3GetFMUState(struct instance *instance, void **state) { return save(instance, state); }
EXPORTED int fmi3SetFMUState(struct instance *instance, void *state) { return restore(instance, state); }

EXPORTED int fmi3FreeFMUState(struct instance *instance, void **state) {
    (void)instance;
    return forget(state);
}

EXPORTED int fmi3SerializedFMUStateSize(struct instance *instance, void *state, size_t *size) {
    (void)instance, (void)state;
    return measure(size);
}

EXPORTED int fmi3SerializeFMUState(struct instance *instance, void *state, unsigned char bytes[], size_t size) {
    return pack(instance, state, bytes, size);
}

EXPORTED int fmi3DeserializeFMUState(struct instance *instance, const unsigned char bytes[], size_t size, void **state) {
    return unpack(instance, bytes, size, state);
}

/* --- what a machine does not have ------------------------------------------------------------------ */

EXPORTED void *fmi3InstantiateModelExchange(void) { return NULL; }
EXPORTED void *fmi3InstantiateScheduledExecution(void) { return NULL; }

#define ABSENT(function)                                                                                                \
    EXPORTED int function(struct instance *instance) {                                                                  \
        return complain(instance, ERROR, "a machine for Co-Simulation has no %s", #function);                           \
    }
ABSENT(fmi3GetFloat32)
ABSENT(fmi3GetInt8)
ABSENT(fmi3GetUInt8)
ABSENT(fmi3GetInt16)
ABSENT(fmi3GetUInt16)
ABSENT(fmi3GetInt32)
ABSENT(fmi3GetUInt32)
ABSENT(fmi3GetUInt64)
ABSENT(fmi3GetBoolean)
ABSENT(fmi3GetString)
ABSENT(fmi3GetBinary)
ABSENT(fmi3GetClock)
ABSENT(fmi3SetFloat32)
ABSENT(fmi3SetInt8)
ABSENT(fmi3SetUInt8)
ABSENT(fmi3SetInt16)
ABSENT(fmi3SetUInt16)
ABSENT(fmi3SetInt32)
ABSENT(fmi3SetUInt32)
ABSENT(fmi3SetInt64)
ABSENT(fmi3SetUInt64)
ABSENT(fmi3SetBoolean)
ABSENT(fmi3SetString)
ABSENT(fmi3SetBinary)
ABSENT(fmi3SetClock)
ABSENT(fmi3GetNumberOfVariableDependencies)
ABSENT(fmi3GetVariableDependencies)
ABSENT(fmi3GetDirectionalDerivative)
ABSENT(fmi3GetAdjointDerivative)
ABSENT(fmi3EnterConfigurationMode)
ABSENT(fmi3ExitConfigurationMode)
ABSENT(fmi3EnterEventMode)
ABSENT(fmi3GetIntervalDecimal)
ABSENT(fmi3GetIntervalFraction)
ABSENT(fmi3GetShiftDecimal)
ABSENT(fmi3GetShiftFraction)
ABSENT(fmi3SetIntervalDecimal)
ABSENT(fmi3SetIntervalFraction)
ABSENT(fmi3SetShiftDecimal)
ABSENT(fmi3SetShiftFraction)
ABSENT(fmi3EvaluateDiscreteStates)
ABSENT(fmi3UpdateDiscreteStates)
ABSENT(fmi3EnterContinuousTimeMode)
ABSENT(fmi3CompletedIntegratorStep)
ABSENT(fmi3SetTime)
ABSENT(fmi3SetContinuousStates)
ABSENT(fmi3GetContinuousStateDerivatives)
ABSENT(fmi3GetEventIndicators)
ABSENT(fmi3GetContinuousStates)
ABSENT(fmi3GetNominalsOfContinuousStates)
ABSENT(fmi3GetNumberOfEventIndicators)
ABSENT(fmi3GetNumberOfContinuousStates)
ABSENT(fmi3EnterStepMode)
ABSENT(fmi3GetOutputDerivatives)
ABSENT(fmi3ActivateModelPartition)
