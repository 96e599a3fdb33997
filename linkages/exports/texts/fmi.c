/* Functions of the interface, by the names and types of its versions 2.0 and 3.0. */

#define CALL(name, ...) EXPORTED int FMI(name)(void *c, __VA_ARGS__)
#define CALL_ALONE(name) EXPORTED int FMI(name)(void *c)
#define REFUSED(name, ...) \
  CALL(name, __VA_ARGS__) { return refuse(c, "%s is not supported", #name); }

static int switched_to(unit *u, int phases, int phase, const char *what) {
  if (may(u, phases, what) != OK) return FAILED;
  u->s.phase = phase;
  return OK;
}

static int count_is(const unit *u, size_t found, size_t expected) {
  if (u == NULL) return FAILED;
  if (found == expected) return OK;
  return refuse(u, "found %lu values; expected %lu", (unsigned long)found, (unsigned long)expected);
}

static int get_values(unit *u, const unsigned *references, size_t count, double *values) {
  int status = u == NULL ? FAILED : OK;
  for (size_t k = 0; k < count && status == OK; k++) {
    status = value_of(u, references[k], &values[k]);
  }
  return status;
}

static int set_values(unit *u, const unsigned *references, size_t count, const double *values) {
  for (size_t k = 0; k < count; k++) {
    if (u == NULL || set_value(u, references[k], values[k]) != OK) return FAILED;
  }
  return OK;
}

static int get_modes(unit *u, const unsigned *references, size_t count, int *values) {
  for (size_t k = 0; k < count; k++) {
    if (u == NULL || mode_of(u, references[k], &values[k]) != OK) return FAILED;
  }
  return OK;
}

static int get_range(unit *u, int first, double *values, size_t found, size_t expected) {
  int status = count_is(u, found, expected);
  for (size_t k = 0; k < expected && status == OK; k++) {
    status = value_of(u, (unsigned)first + (unsigned)k, &values[k]);
  }
  return status;
}

EXPORTED const char *FMI(GetVersion)(void) { return VERSION; }

CALL(SetDebugLogging, boolean on, size_t count, const char *const categories[]) {
  (void)on, (void)count, (void)categories; /* errors alone are logged */
  return c == NULL ? FAILED : OK;
}

EXPORTED void FMI(FreeInstance)(void *c) {
  if (c != NULL) free(((unit *)c)->name);
  free(c);
}

CALL_ALONE(ExitInitializationMode) { return exit_initialization(c); }
CALL_ALONE(Terminate) { return switched_to(c, LIVE, ENDED, "termination"); }

CALL_ALONE(Reset) {
  if (c == NULL) return FAILED;
  reset(c);
  return OK;
}

CALL(GET_STATE, void **state) {
  if (c == NULL) return FAILED;
  if (*state == NULL) *state = malloc(sizeof(unit_state));
  if (*state == NULL) return refuse(c, "out of memory");
  memcpy(*state, &((unit *)c)->s, sizeof(unit_state));
  return OK;
}

CALL(SET_STATE, void *state) { return c == NULL || state == NULL ? FAILED : restored(c, state); }

CALL(FREE_STATE, void **state) {
  if (c == NULL) return FAILED;
  if (state != NULL) {
    free(*state);
    *state = NULL;
  }
  return OK;
}

CALL(SERIALIZED_SIZE, void *state, size_t *size) {
  if (c == NULL || state == NULL) return FAILED;
  *size = sizeof(unit_state);
  return OK;
}

CALL(SERIALIZE, void *state, byte *bytes, size_t size) {
  if (c == NULL || state == NULL || count_is(c, size, sizeof(unit_state)) != OK) return FAILED;
  memcpy(bytes, state, size);
  return OK;
}

CALL(DESERIALIZE, const byte *bytes, size_t size, void **state) {
  if (c == NULL || count_is(c, size, sizeof(unit_state)) != OK) return FAILED;
  if (memcmp(bytes, TOKEN, sizeof TOKEN) != 0) return refuse(c, "found the state of another unit");
  if (*state == NULL) *state = malloc(size);
  if (*state == NULL) return refuse(c, "out of memory");
  memcpy(*state, bytes, size);
  return OK;
}

/* Model exchange */

CALL_ALONE(EnterEventMode) { return switched_to(c, CONTINUOUS | EVENTS, EVENTS, "event mode"); }

CALL_ALONE(EnterContinuousTimeMode) {
  if (switched_to(c, EVENTS, CONTINUOUS, "continuous-time mode") != OK) return FAILED;
  remember(c);
  return OK;
}

CALL(CompletedIntegratorStep, boolean settled, boolean *event, boolean *terminate) {
  int found = 0;
  (void)settled;
  if (may(c, CONTINUOUS, "a completed step") != OK || completed(c, &found) != OK) return FAILED;
  *event = found != 0;
  *terminate = 0;
  return OK;
}

CALL(SetTime, double t) {
  unit *u = c;
  if (may(u, EVENTS | CONTINUOUS, "time") != OK) return FAILED;
  if (!isfinite(t)) return refuse(u, "time: expected a finite number");
  u->s.t = t;
  changed(u);
  return OK;
}

CALL(SetContinuousStates, const double *x, size_t count) {
  unit *u = c;
  if (may(u, EVENTS | CONTINUOUS, "states") != OK || count_is(u, count, STATES) != OK) return FAILED;
  for (int k = 0; k < STATES; k++) {
    if (!isfinite(x[k])) return refuse(u, "state %d: found %.9g; expected a finite number", k, x[k]);
    u->s.y[STATE_ROWS[k]] = x[k];
  }
  changed(u);
  return OK;
}

CALL(GetContinuousStates, double *x, size_t count) {
  return get_range(c, FIRST_STATE, x, count, STATES);
}

CALL(GET_RATES, double *rates, size_t count) {
  return get_range(c, FIRST_RATE, rates, count, STATES);
}

CALL(GetEventIndicators, double *indicators, size_t count) {
  return get_range(c, FIRST_INDICATOR, indicators, count, MODES + CHANGE_POINTS);
}

CALL(GetNominalsOfContinuousStates, double *nominals, size_t count) {
  if (count_is(c, count, STATES) != OK) return FAILED;
  for (size_t k = 0; k < count; k++) nominals[k] = NOMINALS[k];
  return OK;
}

#if FMI_VERSION == 2

EXPORTED const char *FMI(GetTypesPlatform)(void) { return "default"; }

EXPORTED void *FMI(Instantiate)(const char *name, int kind, const char *token, const char *place,
                                const callbacks *given, int visible, int logging) {
  (void)place, (void)visible, (void)logging;
  return given == NULL ? NULL
                       : instantiate(name, token, kind == 0, given->log, given->environment);
}

CALL(SetupExperiment, int defined, double tolerance, double start, int ends, double stop) {
  unit *u = c;
  (void)ends, (void)stop;
  if (enter_initialization(u, start, defined, tolerance) != OK) return FAILED;
  u->s.phase = INSTANTIATED;
  return OK;
}

CALL_ALONE(EnterInitializationMode) {
  return c == NULL ? FAILED : enter_initialization(c, ((unit *)c)->s.start, 0, 0.0);
}

CALL(GetReal, const unsigned *references, size_t count, double *values) {
  return get_values(c, references, count, values);
}

CALL(SetReal, const unsigned *references, size_t count, const double *values) {
  return set_values(c, references, count, values);
}

CALL(GetInteger, const unsigned *references, size_t count, int *values) {
  return get_modes(c, references, count, values);
}

#define NONE_OF(name, type) \
  CALL(name, const unsigned *references, size_t count, type values) { \
    (void)references, (void)values; \
    return count_is(c, count, 0); \
  }
NONE_OF(SetInteger, const int *)
NONE_OF(GetBoolean, int *)
NONE_OF(SetBoolean, const int *)
NONE_OF(GetString, const char **)
NONE_OF(SetString, const char *const *)

CALL(GetDirectionalDerivative, const unsigned *unknowns, size_t found, const unsigned *knowns,
     size_t given, const double *seed, double *result) {
  return derivatives(c, unknowns, found, knowns, given, seed, result);
}

CALL(NewDiscreteStates, event_information *event) {
  int moved = 0;
  if (may(c, EVENTS, "an event") != OK || react(c, &moved) != OK) return FAILED;
  memset(event, 0, sizeof *event);
  event->moved = moved;
  event->defined = ((unit *)c)->s.across;
  event->next = next_event(c);
  return OK;
}

CALL(DoStep, double from, double size, int settled) {
  double reached;
  (void)settled;
  return c == NULL ? FAILED : do_step(c, from, size, &reached);
}

CALL(GetRealStatus, int kind, double *value) {
  if (may(c, STEPPING, "the status of a step") != OK) return FAILED;
  if (kind != 2) return DISCARD;
  *value = ((unit *)c)->s.t;
  return OK;
}

CALL(GetBooleanStatus, int kind, int *value) {
  if (may(c, STEPPING, "the status of a step") != OK) return FAILED;
  if (kind != 3) return DISCARD;
  *value = 0;
  return OK;
}

#define NO_STATUS(name, type) \
  CALL(name, int kind, type value) { \
    (void)kind, (void)value; \
    return c == NULL ? FAILED : DISCARD; \
  }
NO_STATUS(GetStatus, int *)
NO_STATUS(GetIntegerStatus, int *)
NO_STATUS(GetStringStatus, const char **)
CALL_ALONE(CancelStep) { return c == NULL ? FAILED : refuse(c, "no step is pending"); }

#define NO_POWERS(name, type) \
  CALL(name, const unsigned *references, size_t count, const int *orders, type values) { \
    (void)references, (void)orders, (void)values; \
    return count_is(c, count, 0); \
  }
NO_POWERS(SetRealInputDerivatives, const double *)
NO_POWERS(GetRealOutputDerivatives, double *)

#else

EXPORTED void *FMI(InstantiateModelExchange)(const char *name, const char *token, const char *place,
                                             bool visible, bool logging, void *environment,
                                             unit_log log) {
  (void)place, (void)visible, (void)logging;
  return instantiate(name, token, 1, log, environment);
}

EXPORTED void *FMI(InstantiateCoSimulation)(
    const char *name, const char *token, const char *place, bool visible, bool logging, bool events,
    bool early, const unsigned *between, size_t count, void *environment, unit_log log,
    unit_update update) {
  (void)place, (void)visible, (void)logging, (void)early, (void)between, (void)count, (void)update;
  if (events) {
    if (log != NULL) log(environment, FAILED, CATEGORY, "co-simulation has no event mode");
    return NULL;
  }
  return instantiate(name, token, 0, log, environment);
}

EXPORTED void *FMI(InstantiateScheduledExecution)(
    const char *name, const char *token, const char *place, bool visible, bool logging,
    void *environment, unit_log log, void (*update)(void *), void (*lock)(void),
    void (*unlock)(void)) {
  (void)name, (void)token, (void)place, (void)visible, (void)logging;
  (void)update, (void)lock, (void)unlock;
  if (log != NULL) log(environment, FAILED, CATEGORY, "scheduled execution is not supported");
  return NULL;
}

CALL(EnterInitializationMode, bool defined, double tolerance, double start, bool ends,
     double stop) {
  (void)ends, (void)stop;
  return enter_initialization(c, start, defined, tolerance);
}

CALL(GetFloat64, const unsigned *references, size_t count, double *values, size_t size) {
  return count_is(c, size, count) != OK ? FAILED : get_values(c, references, count, values);
}

CALL(SetFloat64, const unsigned *references, size_t count, const double *values, size_t size) {
  return count_is(c, size, count) != OK ? FAILED : set_values(c, references, count, values);
}

CALL(GetInt32, const unsigned *references, size_t count, int32_t *values, size_t size) {
  return count_is(c, size, count) != OK ? FAILED : get_modes(c, references, count, values);
}

#define NONE_TO_SET(name, type) \
  CALL(Set##name, const unsigned *references, size_t count, type const *values, size_t size) { \
    (void)references, (void)values, (void)size; \
    return count_is(c, count, 0); \
  }
#define NONE_OF(name, type) \
  CALL(Get##name, const unsigned *references, size_t count, type *values, size_t size) { \
    (void)references, (void)values, (void)size; \
    return count_is(c, count, 0); \
  } \
  NONE_TO_SET(name, type)
NONE_OF(Float32, float)
NONE_OF(Int8, int8_t)
NONE_OF(UInt8, uint8_t)
NONE_OF(Int16, int16_t)
NONE_OF(UInt16, uint16_t)
NONE_TO_SET(Int32, int32_t)
NONE_OF(UInt32, uint32_t)
NONE_OF(Int64, int64_t)
NONE_OF(UInt64, uint64_t)
NONE_OF(Boolean, bool)
NONE_OF(String, const char *)

#define NONE_LIKE(name, ...) \
  CALL(name, const unsigned *references, size_t count, __VA_ARGS__) { \
    (void)references; \
    return count_is(c, count, 0); \
  }
NONE_LIKE(GetBinary, size_t *sizes, const uint8_t **values, size_t size)
NONE_LIKE(SetBinary, const size_t *sizes, const uint8_t *const *values, size_t size)
NONE_LIKE(GetClock, bool *values)
NONE_LIKE(SetClock, const bool *values)
NONE_LIKE(GetIntervalDecimal, double *intervals, int *qualifiers)
NONE_LIKE(GetIntervalFraction, uint64_t *counters, uint64_t *resolutions, int *qualifiers)
NONE_LIKE(GetShiftDecimal, double *shifts)
NONE_LIKE(GetShiftFraction, uint64_t *counters, uint64_t *resolutions)
NONE_LIKE(SetIntervalDecimal, const double *intervals)
NONE_LIKE(SetIntervalFraction, const uint64_t *counters, const uint64_t *resolutions)
NONE_LIKE(SetShiftDecimal, const double *shifts)
NONE_LIKE(SetShiftFraction, const uint64_t *counters, const uint64_t *resolutions)
NONE_LIKE(GetOutputDerivatives, const int32_t *orders, double *values, size_t size)
REFUSED(GetNumberOfVariableDependencies, unsigned reference, size_t *count)
REFUSED(GetVariableDependencies, unsigned of, size_t *elements, unsigned *by, size_t *indices,
        int *kinds, size_t count)
REFUSED(GetAdjointDerivative, const unsigned *unknowns, size_t found, const unsigned *knowns,
        size_t given, const double *seed, size_t seeds, double *result, size_t results)
REFUSED(ActivateModelPartition, unsigned clock, double time)
CALL_ALONE(EnterConfigurationMode) { return refuse(c, "no structure can be configured"); }
CALL_ALONE(ExitConfigurationMode) { return refuse(c, "no structure can be configured"); }
CALL_ALONE(EvaluateDiscreteStates) { return may(c, EVENTS, "discrete states"); }
CALL_ALONE(EnterStepMode) { return refuse(c, "co-simulation has no event mode"); }

CALL(GetDirectionalDerivative, const unsigned *unknowns, size_t found, const unsigned *knowns,
     size_t given, const double *seed, size_t seeds, double *result, size_t results) {
  if (count_is(c, seeds, given) != OK || count_is(c, results, found) != OK) return FAILED;
  return derivatives(c, unknowns, found, knowns, given, seed, result);
}

CALL(UpdateDiscreteStates, bool *again, bool *terminate, bool *nominals, bool *values,
     bool *defined, double *next) {
  int moved = 0;
  if (may(c, EVENTS, "an event") != OK || react(c, &moved) != OK) return FAILED;
  *again = *terminate = *nominals = false;
  *values = moved != 0;
  *defined = ((unit *)c)->s.across != 0;
  *next = next_event(c);
  return OK;
}

CALL(GetNumberOfEventIndicators, size_t *count) {
  *count = MODES + CHANGE_POINTS;
  return c == NULL ? FAILED : OK;
}

CALL(GetNumberOfContinuousStates, size_t *count) {
  *count = STATES;
  return c == NULL ? FAILED : OK;
}

CALL(DoStep, double from, double size, bool settled, bool *event, bool *terminate, bool *early,
     double *reached) {
  (void)settled;
  *event = *terminate = *early = false;
  return c == NULL ? FAILED : do_step(c, from, size, reached);
}

#endif
