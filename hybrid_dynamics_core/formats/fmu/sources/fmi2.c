/* The functions of FMI 2.0, for model exchange and co-simulation. */
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
#ifdef FMI2_FUNCTION_PREFIX
#define NAME(name) JOIN(FMI2_FUNCTION_PREFIX, name)
#else
#define NAME(name) name
#endif
#define FMI(name) EXPORT status_t NAME(fmi2##name)

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL, PENDING } status_t;
typedef enum { MODEL_EXCHANGE, CO_SIMULATION } kind_t;
typedef enum { DO_STEP_STATUS, PENDING_STATUS, LAST_TIME, TERMINATED } asked_t;
typedef unsigned int reference_t;
typedef int bool_t;
typedef const char *text_t;

typedef struct {
    void (*log)(void *environment, text_t name, status_t status, text_t category, text_t message,
                ...);
    void *(*allocate)(size_t count, size_t size);
    void (*release)(void *memory);
    void (*finished)(void *environment, status_t status);
    void *environment;
} callbacks_t;

typedef struct {
    bool_t new_states_needed, terminate, new_nominals, new_values, has_next;
    double next;
} event_t;

typedef struct {
    unit_data data;
    const callbacks_t *callbacks;
    char *name;
    double last_time;
    int ended; /* whether the last step could not be done whole */
} instance_t;

static status_t say(instance_t *self, status_t status, const char *message)
{
    const callbacks_t *callbacks = self->callbacks;
    if (callbacks->log != NULL) {
        const char *categories[] = {"", "logStatusWarning", "logStatusDiscard", "logStatusError"};
        callbacks->log(callbacks->environment, self->name, status, categories[status], "%s",
                       message);
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

EXPORT const char *NAME(fmi2GetTypesPlatform)(void)
{
    return "default";
}

EXPORT const char *NAME(fmi2GetVersion)(void)
{
    return "2.0";
}

FMI(SetDebugLogging)(void *c, bool_t on, size_t n, const text_t categories[])
{
    (void)c, (void)on, (void)n, (void)categories;
    return OK;
}

EXPORT void *NAME(fmi2Instantiate)(text_t name, kind_t kind, text_t token, text_t resources,
                                   const callbacks_t *callbacks, bool_t visible, bool_t logging)
{
    instance_t *self;
    (void)kind, (void)resources, (void)visible, (void)logging;
    if (callbacks == NULL || callbacks->allocate == NULL || callbacks->release == NULL
        || name == NULL) {
        return NULL;
    }
    self = callbacks->allocate(1, sizeof *self);
    if (self == NULL) {
        return NULL;
    }
    self->callbacks = callbacks;
    self->name = callbacks->allocate(strlen(name) + 1, 1);
    if (self->name == NULL) {
        callbacks->release(self);
        return NULL;
    }
    memcpy(self->name, name, strlen(name) + 1);
    if (token == NULL || strcmp(token, UNIT_TOKEN) != 0) {
        say(self, ERROR, "the GUID is that of another unit");
        callbacks->release(self->name);
        callbacks->release(self);
        return NULL;
    }
    reset(&self->data);
    return self;
}

EXPORT void NAME(fmi2FreeInstance)(void *c)
{
    instance_t *self = c;
    if (self != NULL) {
        void (*release)(void *) = self->callbacks->release;
        release(self->name);
        release(self);
    }
}

FMI(SetupExperiment)(void *c, bool_t has_tolerance, double tolerance, double start, bool_t has_stop,
                     double stop)
{
    instance_t *self = c;
    (void)has_stop, (void)stop;
    if (has_tolerance && !(tolerance > 0.0)) {
        return say(self, ERROR, "the tolerance is not above zero");
    }
    if (has_tolerance) {
        self->data.tolerance = tolerance;
    }
    self->data.value[V_TIME] = self->last_time = start;
    return OK;
}

FMI(EnterInitializationMode)(void *c)
{
    (void)c;
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

FMI(GetReal)(void *c, const reference_t references[], size_t n, double values[])
{
    instance_t *self = c;
    for (size_t k = 0; k < n; ++k) {
        int status;
        if (references[k] >= V_COUNT) {
            return say(self, ERROR, "there is no such value reference");
        }
        status = refresh(&self->data, what_of(references[k]));
        if (status != UNIT_OK) {
            return answer(self, status);
        }
        values[k] = self->data.value[references[k]];
    }
    return OK;
}

FMI(SetReal)(void *c, const reference_t references[], size_t n, const double values[])
{
    instance_t *self = c;
    for (size_t k = 0; k < n; ++k) {
        if (references[k] >= V_COUNT || !is_settable(&self->data, references[k])) {
            return say(self, ERROR, "a value that may not be set now");
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
    FMI(Get##type)(void *c, const reference_t references[], size_t n, value_t values[])        \
    {                                                                                          \
        (void)references, (void)values;                                                        \
        return no_such_type(c, n);                                                             \
    }                                                                                          \
    FMI(Set##type)(void *c, const reference_t references[], size_t n, const value_t values[])  \
    {                                                                                          \
        (void)references, (void)values;                                                        \
        return no_such_type(c, n);                                                             \
    }
NO_VARIABLES(Integer, int)
NO_VARIABLES(String, text_t)

FMI(GetBoolean)(void *c, const reference_t references[], size_t n, bool_t values[])
{
    instance_t *self = c;
    for (size_t k = 0; k < n; ++k) {
        if (references[k] != V_STOP) {
            return no_such_type(c, n);
        }
        values[k] = self->data.stops != 0;
    }
    return OK;
}

FMI(SetBoolean)(void *c, const reference_t references[], size_t n, const bool_t values[])
{
    instance_t *self = c;
    for (size_t k = 0; k < n; ++k) {
        if (references[k] != V_STOP || self->data.initialised) {
            return say(self, ERROR, "a value that may not be set now");
        }
        self->data.stops = values[k] ? 1 : 0;
    }
    return OK;
}

static status_t not_here(void *c)
{
    return say(c, ERROR, "the unit has no such capability; see its modelDescription.xml");
}

FMI(GetFMUstate)(void *c, void **state)
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

FMI(SetFMUstate)(void *c, void *state)
{
    instance_t *self = c;
    memcpy(&self->data, state, sizeof self->data);
    return OK;
}

FMI(FreeFMUstate)(void *c, void **state)
{
    (void)c;
    if (state != NULL) {
        free(*state);
        *state = NULL;
    }
    return OK;
}

FMI(SerializedFMUstateSize)(void *c, void *state, size_t *size)
{
    (void)c, (void)state;
    *size = sizeof(unit_data);
    return OK;
}

FMI(SerializeFMUstate)(void *c, void *state, char bytes[], size_t size)
{
    if (size != sizeof(unit_data)) {
        return say(c, ERROR, "a state has another size");
    }
    memcpy(bytes, state, size);
    return OK;
}

FMI(DeSerializeFMUstate)(void *c, const char bytes[], size_t size, void **state)
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

FMI(EnterEventMode)(void *c)
{
    (void)c;
    return OK;
}

FMI(NewDiscreteStates)(void *c, event_t *event)
{
    instance_t *self = c;
    memset(event, 0, sizeof *event);
    if (limit_of(&self->data, 1) < N_LIMITS) {
        event->terminate = 1;
        say(self, WARNING, unit_limits[limit_of(&self->data, 1)].text);
    }
    return OK;
}

FMI(EnterContinuousTimeMode)(void *c)
{
    (void)c;
    return OK;
}

FMI(CompletedIntegratorStep)(void *c, bool_t no_return, bool_t *event_mode, bool_t *terminate)
{
    instance_t *self = c;
    (void)no_return;
    *event_mode = *terminate = 0;
    return answer(self, accept(&self->data));
}

#define DERIVATIVES FMI(GetDerivatives)
#include "continuous.h"

FMI(GetDirectionalDerivative)(void *c, const reference_t unknowns[], size_t n,
                              const reference_t knowns[], size_t m, const double seed[],
                              double sensitivity[])
{
    return directional(c, unknowns, n, knowns, m, seed, sensitivity);
}

FMI(SetRealInputDerivatives)(void *c, const reference_t references[], size_t n, const int orders[],
                             const double values[])
{
    (void)references, (void)n, (void)orders, (void)values;
    return not_here(c);
}

FMI(GetRealOutputDerivatives)(void *c, const reference_t references[], size_t n, const int orders[],
                              double values[])
{
    (void)references, (void)n, (void)orders, (void)values;
    return not_here(c);
}

FMI(DoStep)(void *c, double time, double length, bool_t no_return)
{
    instance_t *self = c;
    double passed = 0.0;
    int status;
    (void)no_return;
    self->last_time = time;
    if (!(length > 0.0) || !isfinite(length)) {
        return say(self, ERROR, "the length of a step is not above zero");
    }
    status = advance(&self->data, length, &passed);
    self->data.fresh = 0;
    self->data.value[V_TIME] = self->last_time = time + passed;
    self->ended = status != UNIT_OK || self->data.limit < N_LIMITS;
    if (self->data.limit < N_LIMITS) {
        return say(self, DISCARD, unit_limits[self->data.limit].text);
    }
    return answer(self, status);
}

FMI(CancelStep)(void *c)
{
    return not_here(c);
}

FMI(GetStatus)(void *c, asked_t asked, status_t *value)
{
    (void)asked, (void)value;
    return not_here(c);
}

FMI(GetRealStatus)(void *c, asked_t asked, double *value)
{
    if (asked != LAST_TIME) {
        return not_here(c);
    }
    *value = ((instance_t *)c)->last_time;
    return OK;
}

FMI(GetIntegerStatus)(void *c, asked_t asked, int *value)
{
    (void)asked, (void)value;
    return not_here(c);
}

FMI(GetBooleanStatus)(void *c, asked_t asked, bool_t *value)
{
    if (asked != TERMINATED) {
        return not_here(c);
    }
    *value = ((instance_t *)c)->ended;
    return OK;
}

FMI(GetStringStatus)(void *c, asked_t asked, text_t *value)
{
    (void)asked, (void)value;
    return not_here(c);
}
