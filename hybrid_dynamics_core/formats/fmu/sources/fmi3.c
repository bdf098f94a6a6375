/* The functions of FMI 3.0, for model exchange and co-simulation. */
#include <stdbool.h>
#include <stdint.h>

#include "unit.h"

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORT __attribute__((visibility("default")))
#else
#define EXPORT
#endif
#define JOINED(a, b) a##b
#define JOIN(a, b) JOINED(a, b)
#ifdef FMI3_FUNCTION_PREFIX
#define NAME(name) JOIN(FMI3_FUNCTION_PREFIX, name)
#else
#define NAME(name) name
#endif
#define FMI(name) EXPORT status_t NAME(fmi3##name)

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL } status_t;
typedef uint32_t reference_t;
typedef void (*log_t)(void *environment, status_t status, const char *category,
                      const char *message);
typedef void (*update_t)(void *environment, double time, bool set, bool get, bool finished,
                         bool early, bool *wants_early, double *early_time);
typedef void (*clock_t_)(void *environment);
typedef void (*lock_t)(void);

typedef struct {
    unit_data data;
    void *environment;
    log_t log;
    bool may_return_early;
} instance_t;

static status_t say(instance_t *self, status_t status, const char *message)
{
    if (self->log != NULL) {
        const char *categories[] = {"ok", "warning", "discard", "error", "fatal"};
        self->log(self->environment, status, categories[status], message);
    }
    return status;
}

/* A status of the model: a state that a shorter step may avoid is discarded. */
static status_t answer(instance_t *self, int status)
{
    if (status == UNIT_OK) {
        return OK;
    }
    return say(self, status == UNIT_SINGULAR_MASS ? ERROR : DISCARD, message_of(status));
}

EXPORT const char *NAME(fmi3GetVersion)(void)
{
    return "3.0";
}

FMI(SetDebugLogging)(void *c, bool on, size_t n, const char *const categories[])
{
    (void)c, (void)on, (void)n, (void)categories;
    return OK;
}

static void *instantiate(const char *token, bool early, void *environment, log_t log)
{
    instance_t *self = calloc(1, sizeof *self);
    if (self == NULL) {
        return NULL;
    }
    self->environment = environment;
    self->log = log;
    self->may_return_early = early;
    if (token == NULL || strcmp(token, UNIT_TOKEN) != 0) {
        say(self, ERROR, "the instantiation token is that of another unit");
        free(self);
        return NULL;
    }
    reset(&self->data);
    return self;
}

EXPORT void *NAME(fmi3InstantiateModelExchange)(
    const char *name, const char *token, const char *resources, bool visible, bool logging,
    void *environment, log_t log)
{
    (void)name, (void)resources, (void)visible, (void)logging;
    return instantiate(token, false, environment, log);
}

EXPORT void *NAME(fmi3InstantiateCoSimulation)(
    const char *name, const char *token, const char *resources, bool visible, bool logging,
    bool events, bool early, const reference_t intermediate[], size_t n, void *environment,
    log_t log, update_t update)
{
    (void)name, (void)resources, (void)visible, (void)logging, (void)events;
    (void)intermediate, (void)n, (void)update;
    return instantiate(token, early, environment, log);
}

EXPORT void *NAME(fmi3InstantiateScheduledExecution)(
    const char *name, const char *token, const char *resources, bool visible, bool logging,
    void *environment, log_t log, clock_t_ clock, lock_t lock, lock_t unlock)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging, (void)environment;
    (void)log, (void)clock, (void)lock, (void)unlock;
    return NULL;
}

EXPORT void NAME(fmi3FreeInstance)(void *c)
{
    free(c);
}

FMI(EnterInitializationMode)(void *c, bool has_tolerance, double tolerance, double start,
                             bool has_stop, double stop)
{
    instance_t *self = c;
    (void)has_stop, (void)stop;
    if (has_tolerance && !(tolerance > 0.0)) {
        return say(self, ERROR, "the tolerance is not above zero");
    }
    if (has_tolerance) {
        self->data.tolerance = tolerance;
    }
    self->data.value[V_TIME] = start;
    return OK;
}

FMI(ExitInitializationMode)(void *c)
{
    instance_t *self = c;
    const int status = accept(&self->data);
    if (status != UNIT_OK) {
        return say(self, ERROR, message_of(status));
    }
    if (limit_of(&self->data, 0) < N_LIMITS) {
        return say(self, ERROR, "the start is beyond a limit");
    }
    self->data.initialised = 1;
    return OK;
}

FMI(EnterEventMode)(void *c)
{
    (void)c;
    return OK;
}

FMI(Terminate)(void *c)
{
    (void)c;
    return OK;
}

FMI(Reset)(void *c)
{
    reset(&((instance_t *)c)->data);
    return OK;
}

FMI(GetFloat64)(void *c, const reference_t references[], size_t n, double values[], size_t count)
{
    instance_t *self = c;
    for (size_t k = 0; k < n; ++k) {
        int status;
        if (references[k] >= V_COUNT || count != n) {
            return say(self, ERROR, "there is no such value reference, or another number of values");
        }
        status = refresh(&self->data, what_of(references[k]));
        if (status != UNIT_OK) {
            return answer(self, status);
        }
        values[k] = self->data.value[references[k]];
    }
    return OK;
}

FMI(SetFloat64)(void *c, const reference_t references[], size_t n, const double values[],
                size_t count)
{
    instance_t *self = c;
    for (size_t k = 0; k < n; ++k) {
        if (references[k] >= V_COUNT || count != n || !is_settable(&self->data, references[k])) {
            return say(self, ERROR, "a value that may not be set now, or another number of values");
        }
        if (!isfinite(values[k])) {
            return say(self, ERROR, message_of(UNIT_NOT_FINITE));
        }
    }
    for (size_t k = 0; k < n; ++k) {
        self->data.value[references[k]] = values[k];
        self->data.fresh = 0;
    }
    return OK;
}

static status_t no_such_type(void *c, size_t n)
{
    return n == 0 ? OK : say(c, ERROR, "there is no variable of this type");
}

#define NO_VARIABLES(type, value_t)                                                            \
    FMI(Get##type)(void *c, const reference_t references[], size_t n, value_t values[],        \
                   size_t count)                                                               \
    {                                                                                          \
        (void)references, (void)values, (void)count;                                           \
        return no_such_type(c, n);                                                             \
    }                                                                                          \
    FMI(Set##type)(void *c, const reference_t references[], size_t n, const value_t values[],  \
                   size_t count)                                                               \
    {                                                                                          \
        (void)references, (void)values, (void)count;                                           \
        return no_such_type(c, n);                                                             \
    }
NO_VARIABLES(Float32, float)
NO_VARIABLES(Int8, int8_t)
NO_VARIABLES(UInt8, uint8_t)
NO_VARIABLES(Int16, int16_t)
NO_VARIABLES(UInt16, uint16_t)
NO_VARIABLES(Int32, int32_t)
NO_VARIABLES(UInt32, uint32_t)
NO_VARIABLES(Int64, int64_t)
NO_VARIABLES(UInt64, uint64_t)
typedef const char *text_t;
NO_VARIABLES(String, text_t)

FMI(GetBoolean)(void *c, const reference_t references[], size_t n, bool values[], size_t count)
{
    instance_t *self = c;
    (void)count;
    for (size_t k = 0; k < n; ++k) {
        if (references[k] != V_STOP) {
            return no_such_type(c, n);
        }
        values[k] = self->data.stops != 0;
    }
    return OK;
}

FMI(SetBoolean)(void *c, const reference_t references[], size_t n, const bool values[], size_t count)
{
    instance_t *self = c;
    (void)count;
    for (size_t k = 0; k < n; ++k) {
        if (references[k] != V_STOP || self->data.initialised) {
            return say(self, ERROR, "a value that may not be set now");
        }
        self->data.stops = values[k] ? 1 : 0;
    }
    return OK;
}

FMI(GetBinary)(void *c, const reference_t references[], size_t n, size_t sizes[],
               const uint8_t *values[], size_t count)
{
    (void)references, (void)sizes, (void)values, (void)count;
    return no_such_type(c, n);
}

FMI(SetBinary)(void *c, const reference_t references[], size_t n, const size_t sizes[],
               const uint8_t *const values[], size_t count)
{
    (void)references, (void)sizes, (void)values, (void)count;
    return no_such_type(c, n);
}

FMI(GetClock)(void *c, const reference_t references[], size_t n, bool values[])
{
    (void)references, (void)values;
    return no_such_type(c, n);
}

FMI(SetClock)(void *c, const reference_t references[], size_t n, const bool values[])
{
    (void)references, (void)values;
    return no_such_type(c, n);
}

static status_t not_here(void *c)
{
    return say(c, ERROR, "the unit has no such capability; see its modelDescription.xml");
}

FMI(GetNumberOfVariableDependencies)(void *c, reference_t reference, size_t *n)
{
    (void)reference, (void)n;
    return not_here(c);
}

FMI(GetVariableDependencies)(void *c, reference_t dependent, size_t of_dependent[],
                             reference_t independents[], size_t of_independents[], int kinds[],
                             size_t n)
{
    (void)dependent, (void)of_dependent, (void)independents, (void)of_independents, (void)kinds;
    (void)n;
    return not_here(c);
}

FMI(GetFMUState)(void *c, void **state)
{
    instance_t *self = c;
    if (*state == NULL) {
        *state = malloc(sizeof self->data);
    }
    if (*state == NULL) {
        return say(self, ERROR, "there is no memory for a state");
    }
    memcpy(*state, &self->data, sizeof self->data);
    return OK;
}

FMI(SetFMUState)(void *c, void *state)
{
    instance_t *self = c;
    memcpy(&self->data, state, sizeof self->data);
    return OK;
}

FMI(FreeFMUState)(void *c, void **state)
{
    (void)c;
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return OK;
}

FMI(SerializedFMUStateSize)(void *c, void *state, size_t *size)
{
    (void)c, (void)state;
    *size = sizeof(unit_data);
    return OK;
}

FMI(SerializeFMUState)(void *c, void *state, uint8_t bytes[], size_t size)
{
    if (size != sizeof(unit_data)) {
        return say(c, ERROR, "a state has another size");
    }
    memcpy(bytes, state, size);
    return OK;
}

FMI(DeserializeFMUState)(void *c, const uint8_t bytes[], size_t size, void **state)
{
    if (size != sizeof(unit_data)) {
        return say(c, ERROR, "a state has another size");
    }
    if (*state == NULL) {
        *state = malloc(size);
    }
    if (*state == NULL) {
        return say(c, ERROR, "there is no memory for a state");
    }
    memcpy(*state, bytes, size);
    return OK;
}

FMI(EnterConfigurationMode)(void *c)
{
    return not_here(c);
}

FMI(ExitConfigurationMode)(void *c)
{
    return not_here(c);
}

FMI(GetIntervalDecimal)(void *c, const reference_t r[], size_t n, double intervals[],
                        int qualifiers[])
{
    (void)r, (void)intervals, (void)qualifiers;
    return no_such_type(c, n);
}

FMI(GetIntervalFraction)(void *c, const reference_t r[], size_t n, uint64_t counters[],
                         uint64_t resolutions[], int qualifiers[])
{
    (void)r, (void)counters, (void)resolutions, (void)qualifiers;
    return no_such_type(c, n);
}

FMI(GetShiftDecimal)(void *c, const reference_t r[], size_t n, double shifts[])
{
    (void)r, (void)shifts;
    return no_such_type(c, n);
}

FMI(GetShiftFraction)(void *c, const reference_t r[], size_t n, uint64_t counters[],
                      uint64_t resolutions[])
{
    (void)r, (void)counters, (void)resolutions;
    return no_such_type(c, n);
}

FMI(SetIntervalDecimal)(void *c, const reference_t r[], size_t n, const double intervals[])
{
    (void)r, (void)intervals;
    return no_such_type(c, n);
}

FMI(SetIntervalFraction)(void *c, const reference_t r[], size_t n, const uint64_t counters[],
                         const uint64_t resolutions[])
{
    (void)r, (void)counters, (void)resolutions;
    return no_such_type(c, n);
}

FMI(SetShiftDecimal)(void *c, const reference_t r[], size_t n, const double shifts[])
{
    (void)r, (void)shifts;
    return no_such_type(c, n);
}

FMI(SetShiftFraction)(void *c, const reference_t r[], size_t n, const uint64_t counters[],
                      const uint64_t resolutions[])
{
    (void)r, (void)counters, (void)resolutions;
    return no_such_type(c, n);
}

FMI(EvaluateDiscreteStates)(void *c)
{
    (void)c;
    return OK;
}

FMI(UpdateDiscreteStates)(void *c, bool *needs_update, bool *terminate, bool *new_nominals,
                          bool *new_states, bool *has_next, double *next)
{
    instance_t *self = c;
    *needs_update = *terminate = *new_nominals = *new_states = *has_next = false;
    *next = 0.0;
    if (limit_of(&self->data, 1) < N_LIMITS) {
        *terminate = true;
        say(self, WARNING, unit_limits[limit_of(&self->data, 1)].text);
    }
    return OK;
}

FMI(EnterContinuousTimeMode)(void *c)
{
    (void)c;
    return OK;
}

FMI(CompletedIntegratorStep)(void *c, bool no_return, bool *event_mode, bool *terminate)
{
    instance_t *self = c;
    (void)no_return;
    *event_mode = *terminate = false;
    return answer(self, accept(&self->data));
}

#define DERIVATIVES FMI(GetContinuousStateDerivatives)
#include "continuous.h"

FMI(GetDirectionalDerivative)(void *c, const reference_t unknowns[], size_t n,
                              const reference_t knowns[], size_t m, const double seed[],
                              size_t n_seed, double sensitivity[], size_t n_sensitivity)
{
    if (n_seed != m || n_sensitivity != n) {
        return say(c, ERROR, "another number of values than of references");
    }
    return directional(c, unknowns, n, knowns, m, seed, sensitivity);
}

FMI(GetAdjointDerivative)(void *c, const reference_t a[], size_t na, const reference_t b[],
                          size_t nb, const double seed[], size_t n_seed, double sensitivity[],
                          size_t n_sensitivity)
{
    (void)a, (void)na, (void)b, (void)nb, (void)seed, (void)n_seed, (void)sensitivity;
    (void)n_sensitivity;
    return not_here(c);
}

FMI(GetNumberOfEventIndicators)(void *c, size_t *n)
{
    (void)c;
    *n = N_LIMITS;
    return OK;
}

FMI(GetNumberOfContinuousStates)(void *c, size_t *n)
{
    (void)c;
    *n = N_STATES;
    return OK;
}

FMI(EnterStepMode)(void *c)
{
    (void)c;
    return OK;
}

FMI(GetOutputDerivatives)(void *c, const reference_t references[], size_t n, const int32_t orders[],
                          double values[], size_t count)
{
    (void)references, (void)n, (void)orders, (void)values, (void)count;
    return not_here(c);
}

FMI(DoStep)(void *c, double time, double length, bool no_return, bool *event, bool *terminate,
            bool *early, double *last_time)
{
    instance_t *self = c;
    double passed = 0.0;
    int status;
    (void)no_return;
    *event = *terminate = *early = false;
    *last_time = time;
    if (!(length > 0.0) || !isfinite(length)) {
        return say(self, ERROR, "the length of a step is not above zero");
    }
    status = advance(&self->data, length, &passed);
    self->data.fresh = 0;
    *last_time = time + passed;
    *early = self->may_return_early && passed < length;
    self->data.value[V_TIME] = *last_time;
    if (self->data.limit < N_LIMITS) {
        *terminate = true;
        say(self, WARNING, unit_limits[self->data.limit].text);
    }
    return answer(self, status);
}

FMI(ActivateModelPartition)(void *c, reference_t clock, double time)
{
    (void)clock, (void)time;
    return not_here(c);
}
