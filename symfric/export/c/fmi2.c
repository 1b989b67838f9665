/* FMI 2.0 for co-simulation around scene_.h: inputs are held, or go on with the derivatives that the master gives. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene_.h"

#if defined(_WIN32)
#define FMI2_EXPORT __declspec(dllexport)
#else
#define FMI2_EXPORT __attribute__((visibility("default")))
#endif

/* the types of the standard */
typedef void *fmi2Component;
typedef void *fmi2ComponentEnvironment;
typedef void *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef char fmi2Char;
typedef const fmi2Char *fmi2String;
typedef char fmi2Byte;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;
typedef void (*fmi2CallbackLogger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
typedef void *(*fmi2CallbackAllocateMemory)(size_t, size_t);
typedef void (*fmi2CallbackFreeMemory)(void *);
typedef void (*fmi2StepFinished)(fmi2ComponentEnvironment, fmi2Status);
typedef struct {
  fmi2CallbackLogger logger;
  fmi2CallbackAllocateMemory allocateMemory;
  fmi2CallbackFreeMemory freeMemory;
  fmi2StepFinished stepFinished;
  fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

/* value references: states, then inputs, outputs, parameters; integers: the modes, then the status of the last step */
enum {
  FIRST_INPUT = SCENE__STATES,
  FIRST_OUTPUT = FIRST_INPUT + SCENE__INPUTS,
  FIRST_PARAMETER = FIRST_OUTPUT + SCENE__OUTPUTS,
  REALS = FIRST_PARAMETER + SCENE__PARAMETERS
};

typedef struct {
  scene__state state;
  double p[SCENE__ARRAY(SCENE__PARAMETERS)], v[SCENE__ARRAY(SCENE__INPUTS)], dv[SCENE__ARRAY(SCENE__INPUTS)];
  double outputs[SCENE__ARRAY(SCENE__OUTPUTS)], modes[SCENE__ARRAY(SCENE__CONTACTS)];
  int stale;   /* whether outputs and modes are to be computed anew */
  int moved;   /* whether a state was set, so that the modes are to be found anew */
  int status;  /* of the last step */
} run_data;

typedef struct {
  run_data data;
  fmi2CallbackLogger logger;
  fmi2ComponentEnvironment environment;
  char name[128];
} instance;

static void set_start(run_data *d) {
  int k;
  memset(d, 0, sizeof *d);
  for (k = 0; k < SCENE__STATES; k++) d->state.x[k] = scene__initial[k];
  for (k = 0; k < SCENE__PARAMETERS; k++) d->p[k] = scene__parameters[k];
  d->stale = d->moved = 1;
}

static void update(run_data *d) {
  if (d->moved) scene__begin(&d->state, d->p, d->v);
  if (d->moved || d->stale) scene__look(&d->state, d->p, d->v, d->outputs, d->modes);
  d->moved = d->stale = 0;
}

static fmi2Status said(instance *it, fmi2Status status, const char *text) {
  if (it->logger)
    it->logger(it->environment, it->name, status, status == fmi2Warning ? "logStatusWarning" : "logStatusError", "%s", text);
  return status;
}

FMI2_EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
FMI2_EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

FMI2_EXPORT fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
  (void)c, (void)on, (void)n, (void)categories;
  return fmi2OK;
}

FMI2_EXPORT fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                          const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                                          fmi2Boolean logging) {
  instance *it;
  (void)resources, (void)visible, (void)logging;
  if (type != fmi2CoSimulation || !guid || strcmp(guid, "@GUID@")) return 0;
  it = (instance *)calloc(1, sizeof *it);
  if (!it) return 0;
  if (functions) it->logger = functions->logger, it->environment = functions->componentEnvironment;
  if (name) strncpy(it->name, name, sizeof it->name - 1);
  set_start(&it->data);
  return it;
}

FMI2_EXPORT void fmi2FreeInstance(fmi2Component c) { free(c); }

FMI2_EXPORT fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean defined, fmi2Real tolerance, fmi2Real start,
                                           fmi2Boolean ends, fmi2Real stop) {
  (void)defined, (void)tolerance, (void)ends, (void)stop;
  ((instance *)c)->data.state.t = start;
  return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
  (void)c;
  return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
  update(&((instance *)c)->data);
  return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2Terminate(fmi2Component c) {
  (void)c;
  return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2Reset(fmi2Component c) {
  set_start(&((instance *)c)->data);
  return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real value[]) {
  instance *it = (instance *)c;
  run_data *d = &it->data;
  size_t k;
  update(d);
  for (k = 0; k < n; k++) {
    if (r[k] >= REALS) return said(it, fmi2Error, "no such real variable");
    if (r[k] >= FIRST_PARAMETER) value[k] = d->p[r[k] - FIRST_PARAMETER];
    else if (r[k] >= FIRST_OUTPUT) value[k] = d->outputs[r[k] - FIRST_OUTPUT];
    else if (r[k] >= FIRST_INPUT) value[k] = d->v[r[k] - FIRST_INPUT];
    else value[k] = d->state.x[r[k]];
  }
  return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real value[]) {
  instance *it = (instance *)c;
  run_data *d = &it->data;
  size_t k;
  for (k = 0; k < n; k++) {
    if (r[k] >= REALS || (r[k] >= FIRST_OUTPUT && r[k] < FIRST_PARAMETER))
      return said(it, fmi2Error, "this variable cannot be set");
    if (r[k] >= FIRST_PARAMETER) d->p[r[k] - FIRST_PARAMETER] = value[k];
    else if (r[k] >= FIRST_INPUT) d->v[r[k] - FIRST_INPUT] = value[k], d->dv[r[k] - FIRST_INPUT] = 0;
    else d->state.x[r[k]] = value[k], d->moved = 1;
  }
  d->stale = 1;
  return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t n,
                                                   const fmi2Integer order[], const fmi2Real value[]) {
  instance *it = (instance *)c;
  size_t k;
  for (k = 0; k < n; k++) {
    if (r[k] < FIRST_INPUT || r[k] >= FIRST_OUTPUT || order[k] != 1)
      return said(it, fmi2Error, "first derivatives of inputs can be set, and no others");
    it->data.dv[r[k] - FIRST_INPUT] = value[k];
  }
  return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Integer value[]) {
  instance *it = (instance *)c;
  size_t k;
  update(&it->data);
  for (k = 0; k < n; k++) {
    if (r[k] > SCENE__CONTACTS) return said(it, fmi2Error, "no such integer variable");
    value[k] = r[k] == SCENE__CONTACTS ? it->data.status : (int)it->data.modes[r[k]];
  }
  return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2DoStep(fmi2Component c, fmi2Real now, fmi2Real length, fmi2Boolean final) {
  instance *it = (instance *)c;
  run_data *d = &it->data;
  int k, i, status, n = (int)ceil(length / SCENE__STEP - 1e-6);
  double first[SCENE__ARRAY(SCENE__INPUTS)];
  (void)final;
  if (!(length > 0)) return said(it, fmi2Error, "the length of a step must be positive");
  if (n < 1) n = 1;
  update(d);
  d->status = 0;
  for (i = 0; i < SCENE__INPUTS; i++) first[i] = d->v[i];
  for (k = 0; k < n; k++) {
    d->state.t = now + length / n * k;
    status = scene__advance(&d->state, d->p, d->v, d->dv, length / n);
    if (status > d->status) d->status = status;
    for (i = 0; i < SCENE__INPUTS; i++) d->v[i] = first[i] + d->dv[i] * (length / n * (k + 1));
  }
  d->state.t = now + length;
  d->stale = 1;
  if (d->status == 3) return said(it, fmi2Error, "the state is not finite: the step is too long for the fastest motion");
  if (d->status == 2) return said(it, fmi2Error, "a normal load became negative: the surfaces would separate");
  if (d->status == 1) said(it, fmi2Warning, "more events in a step than it resolves; the rest of it is of first order");
  return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *kept) {
  if (!*kept) *kept = malloc(sizeof(run_data));
  if (!*kept) return said((instance *)c, fmi2Error, "no memory");
  memcpy(*kept, &((instance *)c)->data, sizeof(run_data));
  return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate kept) {
  memcpy(&((instance *)c)->data, kept, sizeof(run_data));
  return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *kept) {
  (void)c;
  free(*kept);
  *kept = 0;
  return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate kept, size_t *size) {
  (void)c, (void)kept;
  *size = sizeof(run_data);
  return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate kept, fmi2Byte bytes[], size_t size) {
  if (size < sizeof(run_data)) return said((instance *)c, fmi2Error, "too few bytes for the state");
  memcpy(bytes, kept, sizeof(run_data));
  return fmi2OK;
}

FMI2_EXPORT fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *kept) {
  if (size < sizeof(run_data)) return said((instance *)c, fmi2Error, "too few bytes for the state");
  *kept = malloc(sizeof(run_data));
  if (!*kept) return said((instance *)c, fmi2Error, "no memory");
  memcpy(*kept, bytes, sizeof(run_data));
  return fmi2OK;
}

/* what the standard demands and this model does not have */
#define ABSENT(c) said((instance *)(c), fmi2Error, "the model has no such thing")
FMI2_EXPORT fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Boolean value[]) {
  (void)r, (void)value;
  return n ? ABSENT(c) : fmi2OK;
}
FMI2_EXPORT fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2String value[]) {
  (void)r, (void)value;
  return n ? ABSENT(c) : fmi2OK;
}
FMI2_EXPORT fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer value[]) {
  (void)r, (void)value;
  return n ? ABSENT(c) : fmi2OK;
}
FMI2_EXPORT fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Boolean value[]) {
  (void)r, (void)value;
  return n ? ABSENT(c) : fmi2OK;
}
FMI2_EXPORT fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2String value[]) {
  (void)r, (void)value;
  return n ? ABSENT(c) : fmi2OK;
}
FMI2_EXPORT fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference a[], size_t n,
                                                    const fmi2ValueReference b[], size_t m, const fmi2Real value[],
                                                    fmi2Real found[]) {
  (void)a, (void)n, (void)b, (void)m, (void)value, (void)found;
  return ABSENT(c);
}
FMI2_EXPORT fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t n,
                                                    const fmi2Integer order[], fmi2Real value[]) {
  (void)r, (void)n, (void)order, (void)value;
  return ABSENT(c);
}
FMI2_EXPORT fmi2Status fmi2CancelStep(fmi2Component c) { return ABSENT(c); }
FMI2_EXPORT fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value) {
  (void)kind, (void)value;
  return ABSENT(c);
}
FMI2_EXPORT fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value) {
  if (kind != fmi2LastSuccessfulTime) return ABSENT(c);
  *value = ((instance *)c)->data.state.t;
  return fmi2OK;
}
FMI2_EXPORT fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Integer *value) {
  (void)kind, (void)value;
  return ABSENT(c);
}
FMI2_EXPORT fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value) {
  if (kind != fmi2Terminated) return ABSENT(c);
  *value = 0;
  return fmi2OK;
}
FMI2_EXPORT fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind kind, fmi2String *value) {
  (void)kind, (void)value;
  return ABSENT(c);
}
