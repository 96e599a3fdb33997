/* An instance of a functional mock-up unit: what all versions of the interface have in common. */

enum { OK, DISCARD = 2, FAILED };
enum { INSTANTIATED = 1, INITIALIZING = 2, EVENTS = 4, CONTINUOUS = 8, STEPPING = 16, ENDED = 32 };
enum {
  LIVE = EVENTS | CONTINUOUS | STEPPING,
  KNOWN = INITIALIZING | LIVE | ENDED,
  FIRST_NUMBER = 1, /* value references; 0 is the time */
  FIRST_INPUT = FIRST_NUMBER + LINKAGE_NUMBERS,
  FIRST_STATE = FIRST_INPUT + INPUTS,
  FIRST_RATE = FIRST_STATE + STATES,
  FIRST_INDICATOR = FIRST_RATE + STATES,
  FIRST_MARGIN = FIRST_INDICATOR + MODES, /* indicators of change points */
  FIRST_OUTPUT = FIRST_MARGIN + CHANGE_POINTS,
  FIRST_MODE = FIRST_OUTPUT + LINKAGE_QUANTITIES,
  NOT_FINITE = -10
};

/* All that a state of the unit consists of, without any address. */
typedef struct {
  char token[sizeof TOKEN];
  int phase, exchange, stale; /* whether numbers have changed since the motion began */
  double t, start, tolerance;
  double y[LINKAGE_STATE + 1], p[LINKAGE_PARAMETERS + 1];
  double numbers[LINKAGE_NUMBERS + 1], inputs[INPUTS + 1];
  /* The last completed step; in co-simulation what integration goes on from. */
  double before, y_before[LINKAGE_STATE + 1], p_before[LINKAGE_PARAMETERS + 1];
  /* In model exchange: whether a change point is being passed, and whether it lies behind; how. */
  int across, over, crosses[BLOCKS + 1];
  crossing way;
  /* Margins at which a way across is looked for, and where there was none. */
  double least[BLOCKS + 1], stopped_at;
  int stopped[BLOCKS + 1];
} unit_state;

typedef struct {
  unit_state s;
  int evaluated, shown; /* whether what follows belongs to the present state */
  int blind; /* status with which the equations have no solution there */
  int known; /* whether margins belong to the last completed step */
  double margins[2 * BLOCKS + 1];
  double y[LINKAGE_STATE + 1], rates[LINKAGE_STATE + 1], outputs[LINKAGE_QUANTITIES + 1];
  evaluation e;
  motion m;
  double goal;
  char *name;
  void *environment;
  unit_log log;
} unit;

/* Logs a message, and returns the status of a call that failed. */
static int refuse(const unit *u, const char *form, ...) {
  char text[1024];
  va_list values;
  va_start(values, form);
  vsnprintf(text, sizeof text, form, values);
  va_end(values);
  if (u == NULL || u->log == NULL) return FAILED;
#if FMI_VERSION == 2
  char form_again[2 * sizeof text], *end = form_again;
  for (const char *from = text; *from; *end++ = *from++) {
    if (*from == '%') *end++ = '%';
  }
  *end = '\0';
  u->log(u->environment, u->name, FAILED, CATEGORY, form_again);
#else
  u->log(u->environment, FAILED, CATEGORY, text);
#endif
  return FAILED;
}

static int ended(const unit *u, double t, int status) {
  if (status == NOT_FINITE) {
    return refuse(u, "at t = %.9g s, accelerations are not finite numbers", t);
  }
  return status ? refuse(u, "at t = %.9g s, %s", t, linkage_message(status)) : OK;
}

static int may(const unit *u, int phases, const char *what) {
  if (u == NULL) return FAILED;
  if (u->s.phase & phases) return OK;
  return refuse(u, "%s: not allowed %s", what,
                u->s.phase == INSTANTIATED ? "before initialization"
                : u->s.phase == INITIALIZING ? "during initialization"
                : u->s.phase == ENDED ? "after termination" : "in this mode");
}

static void changed(unit *u) { u->evaluated = u->shown = 0; }

static void remember(unit *u) {
  unit_state *s = &u->s;
  u->known = 0;
  s->before = s->t;
  memcpy(s->y_before, s->y, sizeof s->y);
  memcpy(s->p_before, s->p, sizeof s->p);
}

static void reach(double t, const double *y, const double *p, void *data) {
  unit *u = data;
  if (t != u->goal) return;
  u->s.t = t;
  for (int i = 0; i < LINKAGE_STATE; i++) u->s.y[i] = y[i];
  for (int i = 0; i < LINKAGE_PARAMETERS; i++) u->s.p[i] = p[i];
}

/* Whether a change point is close ahead, or so close behind that its margin is round-off. */
static int approaches(unit *u, double sign) {
  unit_state *s = &u->s;
  if (!PASSING || BLOCKS == 0 || look(s->t, s->y, s->p, &u->e)) return 0;
  for (int k = 0; k < BLOCKS; k++) {
    const double margin = u->e.work[MARGIN + k], size = fabs(margin) / SCALES[k];
    const int falls = margin * u->e.work[MARGIN + BLOCKS + k] * sign < 0.0;
    if (size < EARLY && (falls || size < 1e2 * LEAST_MARGIN)) return 1;
  }
  return 0;
}

/* Follows the motion to a time. Near a change point integration goes on from before, so that how it
   is passed does not depend on communications; the step across may end beyond one. */
static int follow(unit *u, double goal, double *reached) {
  unit_state *s = &u->s;
  const linkage_options options = {"dop853", 0.0, s->tolerance, 0.01 * s->tolerance};
  const double times[] = {s->before, goal};
  double y[LINKAGE_STATE + 1], p[LINKAGE_PARAMETERS + 1];
  memcpy(y, s->y_before, sizeof y);
  memcpy(p, s->p_before, sizeof p);
  u->goal = goal;
  changed(u);
  const int status = linkage_integrate(p, y, times, 2, &options, reach, u, reached);
  if (!status && *reached == goal && !approaches(u, goal < s->before ? -1.0 : 1.0)) remember(u);
  return status;
}

/* Parameters and initial state; motions begin at t = 0, whenever the first communication is. */
static int begin(unit *u) {
  unit_state *s = &u->s;
  double reached = 0.0;
  int status = linkage_start(s->numbers, s->p, s->y);
  changed(u);
  s->stale = 0;
  s->t = 0.0;
  for (int k = 0; k < INPUTS; k++) s->p[INPUT_PLACES[k]] = s->inputs[k];
  prepare(s->p);
  if (!status && MODES > 0) status = activate_modes(0.0, s->y, s->p, &u->e);
  remember(u);
  if (!status && s->start != 0.0) status = follow(u, s->start, &reached);
  return ended(u, reached, status);
}

static int is_across(const unit *u) {
  return u->s.across && u->s.t <= u->s.way.t[u->s.way.last];
}

/* Near a change point accelerations follow from the step across it, as a polynomial of time: the
   equations have lost their digits there. Links are on the side on which they are by then. */
static void lead_across(unit *u, double *accelerations) {
  unit_state *s = &u->s;
  double weights[PLACES];
  if ((s->t > s->way.crossing) != s->over) {
    flip(s->p, s->crosses);
    s->over = !s->over;
  }
  if (!is_across(u)) return;
  cardinals(s->way.t, s->way.last + 1, s->t, weights);
  for (int i = 0; i < N; i++) {
    accelerations[i] = 0.0;
    for (int j = 0; j <= s->way.last; j++) accelerations[i] += weights[j] * s->way.a[j][i];
  }
}

/* Evaluates the equations where the unit is now. A trial step of a master may lead to where there
   are no solutions: then a shorter one may succeed. */
static int evaluate(unit *u) {
  unit_state *s = &u->s;
  double accelerations[N + 1] = {0};
  int status = 0;
  if (s->stale && begin(u) != OK) return FAILED;
  if (u->evaluated) return OK;
  memcpy(u->y, s->y, sizeof s->y);
  if (s->across) lead_across(u, accelerations);
  if (CARRIED > 0) status = close_loops(s->t, u->y, s->p, &u->e);
  if (!status) status = slopes_at(s->t, u->y, s->p, &u->e, u->rates);
  u->blind = 0;
  if (is_across(u)) {
    u->blind = status;
    status = 0;
    for (int i = 0; i < N; i++) {
      u->rates[i] = i >= FREE && i < FIRST_CARRIED ? 0.0 : s->y[N + i];
      u->rates[N + i] = u->e.work[i] = accelerations[i];
    }
  }
  for (int i = 0; i < N && !status; i++) {
    if (!isfinite(u->e.work[i])) status = NOT_FINITE;
  }
  for (int k = 0; k < BLOCKS && status == NOT_FINITE; k++) {
    if (!(fabs(u->e.work[MARGIN + k]) >= LEAST_MARGIN * SCALES[k])) {
      status = SINGULAR + BLOCK_NUMBERS[k];
    }
  }
  u->evaluated = !status;
  return ended(u, s->t, status) == OK ? OK : s->phase == CONTINUOUS ? DISCARD : FAILED;
}

/* The state, then accelerations, of the last evaluation. */
static void fill(const unit *u, double *full) {
  for (int i = 0; i < LINKAGE_STATE; i++) full[i] = u->y[i];
  for (int i = 0; i < N; i++) full[LINKAGE_STATE + i] = u->e.work[i];
}

static int show(unit *u) {
  double full[3 * N + 1];
  int status = evaluate(u);
  if (status != OK || u->shown) return status;
  if (u->blind) return ended(u, u->s.t, u->blind);
  fill(u, full);
  status = outputs_of(full, u->s.p, &u->e, u->outputs);
  u->shown = !status;
  return ended(u, u->s.t, status);
}

/* Whether a mode has to change: its function is behind zero, or there and goes on. Where a body is
   thrown back the function of its contact still lies behind zero, and returns. */
static int crossed(unit *u, const evaluation *e, int k) {
  const double mode = u->s.p[HELD + k], side = mode == 0.0 ? 1.0 : mode;
  const double value = e->work[FUNCTION + k], rate = e->work[FUNCTION + MODES + k];
  if (!is_watched(&u->m, k) || side * value > 0.0) return 0;
  if (value == 0.0) return side * rate < 0.0;
  return !(JUMPS[k] >= 0 && mode < 0.0 && rate <= 0.0);
}

/* Negative where a mode has to change: sign that turns the function of a mode into an indicator. */
static double turned(unit *u, int k) {
  if (!is_watched(&u->m, k)) return 0.0;
  return (u->e.work[FUNCTION + k] < 0.0) == crossed(u, &u->e, k) ? 1.0 : -1.0;
}

/* Whether a master tells of a crossing to a side so late that its function returns already. */
static int located_late(unit *u, int k, double side) {
  const double value = function_ahead(&u->m, k), rate = rate_ahead(&u->m, k);
  return side * value > 1e-9 * fmax(fabs(u->s.t), 1e-3) * fabs(rate);
}

static int cannot_pass(const unit *u, double t, int status) {
  if (status < SINGULAR || status >= SLIDING || !PASSING) return ended(u, t, status);
  return refuse(u, "at t = %.9g s, %s%s", t, linkage_message(status),
                CHANGE_POINTS > 0 ? " A master that locates events, or takes shorter steps, may "
                                    "find a way on." : "");
}

/* Whether a block comes close to a change point: zero where a way across is looked for. It also says
   so where a step leads beyond one, with links on the side on which they were. */
static double change_point_near(unit *u, int k) {
  unit_state *s = &u->s;
  const double h = s->t - s->before;
  const double margin = u->e.work[MARGIN + k], rate = u->e.work[MARGIN + BLOCKS + k];
  if (s->across) return 1.0;
  if (!u->known) {
    const int status = look(s->before, s->y_before, s->p_before, &u->m.e);
    for (int i = 0; i < 2 * BLOCKS; i++) u->margins[i] = status ? 0.0 : u->m.e.work[MARGIN + i];
    u->known = 1;
  }
  if (passes_zero(u->margins[k], h * u->margins[BLOCKS + k], margin, h * rate)) return -1.0;
  return margin * rate < 0.0 ? fabs(margin) / SCALES[k] - s->least[k] : 1.0;
}

/* Says how small margins may become. */
static void set_margins(unit *u, motion *m) {
  unit_state *s = &u->s;
  memcpy(m->stopped, s->stopped, sizeof s->stopped);
  set_least(m);
  memcpy(s->least, m->least, sizeof s->least);
}

/* Begins or ends the way across a change point, where it is time to; row 0 is evaluated. */
static int pass(unit *u, motion *m) {
  unit_state *s = &u->s;
  int near = -1, status = 0;
  if (s->across) {
    const double end = s->way.t[s->way.last];
    if (s->t < end - 1e-12 * fmax(fabs(end), 1e-3)) return 0;
    if (s->t <= end + 1e-12 * fmax(fabs(end), 1e-3)) {
      memcpy(m->y, s->way.y[s->way.last], sizeof m->y);
    }
    if (!s->over) flip(s->p, s->crosses);
    s->across = s->over = 0;
    memset(s->stopped, 0, sizeof s->stopped);
    status = reevaluate(m, s->t);
  }
  for (int k = 0; k < CHANGE_POINTS && near < 0; k++) {
    memcpy(m->least, s->least, sizeof s->least);
    if (is_too_small(m, &m->e, k)) near = k;
  }
  if (status || near < 0) {
    if (!status) set_margins(u, m);
    return status;
  }
  if (s->least[near] <= LEAST_MARGIN) return SINGULAR + BLOCK_NUMBERS[near];
  if (way_across(m, &s->way, s->crosses)) {
    s->across = 1;
    s->over = 0;
    return 0;
  }
  if (s->t != s->stopped_at) memset(s->stopped, 0, sizeof s->stopped);
  s->stopped_at = s->t;
  s->stopped[near] = 1;
  set_margins(u, m);
  return 0;
}

/* Changes modes whose functions have crossed zero, and whatever jumps with them. */
static int react(unit *u, int *moved) {
  unit_state *s = &u->s;
  motion *m = &u->m;
  m->t = s->t;
  m->sign = 1.0;
  m->rtol = s->tolerance;
  m->atol = 0.01 * s->tolerance;
  memcpy(m->y, s->y, sizeof s->y);
  int status = is_across(u) ? 0 : close_loops(s->t, m->y, s->p, &m->e), k = 0;
  if (CHANGE_POINTS > 0 && !status) {
    if (!s->across) status = reevaluate(m, s->t);
    if (!status) status = pass(u, m);
  }
  while (!status && !s->across) {
    status = reevaluate(m, s->t);
    for (k = 0; !status && k < MODES && !crossed(u, &m->e, k);) k++;
    if (status || k == MODES) break;
    m->pending = k;
    const double mode = s->p[HELD + k];
    status = apply_switch(m, s->t);
    if (status == SLIDING + k && located_late(u, k, s->p[HELD + k])) {
      status = chatters(m, s->t) ? CHATTER + k : 0;
    } else if (!status && mode == s->p[HELD + k] && (JUMPS[k] < 0 || mode > 0.0) &&
               located_late(u, k, -mode)) {
      /* taken back as if it were round-off, which it is not */
      s->p[HELD + k] = -mode;
      status = propagate_modes(m, k, 0, s->t);
    }
  }
  *moved = 0;
  for (int i = 0; i < STATES; i++) *moved |= m->y[STATE_ROWS[i]] != s->y[STATE_ROWS[i]];
  memcpy(s->y, m->y, sizeof s->y);
  changed(u);
  remember(u);
  return cannot_pass(u, s->t, status);
}

/* The same where drives determine the motion: positions are functions of time, which go on behind a
   change point with links on their other side. One that is close to the end of the step waits. */
static int led(unit *u, const double *here, int *waits) {
  unit_state *s = &u->s;
  motion *m = &u->m;
  double a = s->before, first[2 * BLOCKS + 1], last[2 * BLOCKS + 1];
  double p[LINKAGE_PARAMETERS + 1];
  int status = margins_at(m, a, first);
  memcpy(last, here, sizeof last);
  memcpy(p, s->p, sizeof p);
  while (!status) {
    status = led_through(m, a, first, s->t, last, 0);
    m->t = a;
    if (status < SINGULAR || !PASSING || !driven_through(m)) break;
    *waits = m->t > s->t;
    if (*waits) memcpy(s->p, p, sizeof p);
    changed(u);
    if (*waits) return OK;
    a = m->t;
    status = margins_at(m, a, first);
    if (!status) status = margins_at(m, s->t, last);
  }
  return cannot_pass(u, m->where, status);
}

/* The part of a long step behind which a margin has passed zero, looked for in shorter pieces; a
   negative number if none has. */
static double overlooked(motion *m, double h) {
  double most = 0.0, before[2 * BLOCKS + 1];
  memcpy(before, m->seen[0], sizeof before);
  for (int k = 0; k < BLOCKS; k++) {
    const double rate = fmax(fabs(before[BLOCKS + k]), fabs(m->seen[m->end][BLOCKS + k]));
    most = fmax(most, fabs(h) * rate / (MOST_CHANGE * SCALES[k]));
  }
  const int pieces = most <= 1.0 ? 0 : (int)fmin(2.0 * most + 1.0, 1000.0);
  for (int j = 1; j <= pieces; j++) {
    const double part = (double)j / pieces, piece = h / pieces, *now = &m->e.work[MARGIN];
    if (look_between(m, h, part)) return part;
    for (int k = 0; k < BLOCKS; k++) {
      const int rate = BLOCKS + k;
      if (passes_zero(before[k], piece * before[rate], now[k], piece * now[rate])) return part;
    }
    memcpy(before, now, 2 * BLOCKS * sizeof *now);
  }
  return -1.0;
}

/* Looks for a singular position within the step that a master has completed. */
static int passed(unit *u, int *waits) {
  unit_state *s = &u->s;
  motion *m = &u->m;
  double last[2 * BLOCKS + 1];
  for (int k = 0; k < 2 * BLOCKS; k++) last[k] = u->e.work[MARGIN + k];
  m->t = s->before;
  m->sign = 1.0;
  m->equal = 1; /* a cubic between both ends */
  m->end = RK4_STAGES;
  memcpy(m->y, s->y_before, sizeof s->y);
  memcpy(m->next, u->y, sizeof s->y);
  if (LINKAGE_STATE == 0) return led(u, last, waits);
  const int status = reevaluate(m, s->before);
  if (status) return ended(u, s->before, status);
  memcpy(m->slopes[RK4_STAGES], u->rates, sizeof u->rates);
  memcpy(m->seen[RK4_STAGES], last, sizeof last);
  for (int k = 0; k < BLOCKS; k++) m->least[k] = LEAST_MARGIN;
  const double h = s->t - s->before;
  int block = singular_within(m, h);
  if (block < 0 && (m->part = overlooked(m, h)) >= 0.0) block = 0;
  if (block < 0) return OK;
  return cannot_pass(u, m->t + m->part * h, SINGULAR + BLOCK_NUMBERS[block]);
}

/* When the way across a change point ends. */
static double next_event(const unit *u) { return u->s.across ? u->s.way.t[u->s.way.last] : 0.0; }

static int completed(unit *u, int *event) {
  int waits = 0;
  if (evaluate(u) != OK) return FAILED;
  *event = 0;
  for (int k = 0; k < MODES && !u->s.across; k++) *event |= crossed(u, &u->e, k);
  if (u->s.across) {
    if (is_across(u)) return OK;
    *event = 1;
  } else if (BLOCKS > 0 && u->s.t > u->s.before && passed(u, &waits) != OK) return FAILED;
  if (waits) return OK;
  memcpy(u->s.y, u->y, sizeof u->s.y); /* the next iterations begin here */
  remember(u);
  return OK;
}

static int value_of(unit *u, unsigned reference, double *value) {
  const unit_state *s = &u->s;
  if (reference < FIRST_STATE) {
    if (reference == 0) *value = s->stale ? s->start : s->t;
    else if (reference < FIRST_INPUT) *value = s->numbers[reference - FIRST_NUMBER];
    else *value = s->inputs[reference - FIRST_INPUT];
    return OK;
  }
  if (reference >= FIRST_MODE) return refuse(u, "no number has the reference %u", reference);
  if (may(u, KNOWN, "states and outputs") != OK) return FAILED;
  const int status = reference < FIRST_OUTPUT ? evaluate(u) : show(u);
  if (status != OK) return status;
  if (reference < FIRST_RATE) *value = u->y[STATE_ROWS[reference - FIRST_STATE]];
  else if (reference < FIRST_INDICATOR) *value = u->rates[STATE_ROWS[reference - FIRST_RATE]];
  else if (reference < FIRST_MARGIN) {
    const int k = (int)reference - FIRST_INDICATOR;
    *value = is_across(u) ? 1.0 : is_watched(&u->m, k) ? turned(u, k) * u->e.work[FUNCTION + k] : 1.0;
  } else if (reference < FIRST_OUTPUT) {
    *value = change_point_near(u, (int)reference - FIRST_MARGIN);
  } else *value = u->outputs[reference - FIRST_OUTPUT];
  return OK;
}

static int mode_of(unit *u, unsigned reference, int *value) {
  if (reference < FIRST_MODE || reference >= FIRST_MODE + MODES) {
    return refuse(u, "no whole number has the reference %u", reference);
  }
  if (may(u, KNOWN, "modes") != OK || evaluate(u) != OK) return FAILED;
  *value = (int)u->s.p[HELD + reference - FIRST_MODE];
  return OK;
}

static int set_value(unit *u, unsigned reference, double value) {
  unit_state *s = &u->s;
  const int number = (int)reference - FIRST_NUMBER, input = (int)reference - FIRST_INPUT;
  if (number >= 0 && input < 0) {
    const char *path = linkage_paths[number];
    const int bound = BOUNDS[number];
    if (may(u, INSTANTIATED | INITIALIZING, path) != OK) return FAILED;
    if (!isfinite(value) || (bound == 1 && value <= 0.0) || (bound == 2 && value < 0.0)) {
      return refuse(u, "%s: found %.9g; expected a finite number%s", path, value,
                    bound == 1 ? " > 0" : bound == 2 ? " >= 0" : "");
    }
    s->numbers[number] = value;
    s->stale = 1;
    return OK;
  }
  if (input < 0 || input >= INPUTS) {
    return refuse(u, "the variable with the reference %u cannot be set", reference);
  }
  if (may(u, ~ENDED, INPUT_NAMES[input]) != OK) return FAILED;
  if (!isfinite(value)) {
    return refuse(u, "%s: found %.9g; expected a finite number", INPUT_NAMES[input], value);
  }
  if (s->inputs[input] == value) return OK;
  s->inputs[input] = value;
  if (s->phase & (INSTANTIATED | INITIALIZING)) {
    s->stale = 1;
    return OK;
  }
  s->p[INPUT_PLACES[input]] = value;
  prepare(s->p);
  changed(u);
  if (!s->exchange) remember(u);
  return OK;
}

static int enter_initialization(unit *u, double start, int defined, double tolerance) {
  if (may(u, INSTANTIATED, "initialization") != OK) return FAILED;
  if (!isfinite(start)) return refuse(u, "start time: expected a finite number");
  if (defined && !(tolerance >= 1e-15 && tolerance < 1.0)) {
    return refuse(u, "tolerance: found %.9g; expected 1e-15 to 1", tolerance);
  }
  if (defined) u->s.tolerance = tolerance;
  u->s.start = start;
  u->s.stale = 1;
  u->s.phase = INITIALIZING;
  return OK;
}

static int exit_initialization(unit *u) {
  if (may(u, INITIALIZING, "end of initialization") != OK || evaluate(u) != OK) return FAILED;
  u->s.phase = u->s.exchange ? EVENTS : STEPPING;
  return OK;
}

static int do_step(unit *u, double from, double size, double *reached) {
  unit_state *s = &u->s;
  *reached = s->t;
  if (may(u, STEPPING, "a step") != OK) return FAILED;
  if (!(fabs(from - s->t) <= 1e-9 * fmax(1.0, fabs(s->t)))) {
    return refuse(u, "the step begins at t = %.17g s; expected %.17g s", from, s->t);
  }
  if (!(size > 0.0 && from + size > s->t && isfinite(from + size))) {
    return refuse(u, "found a step of %.9g s; expected one > 0", size);
  }
  return ended(u, *reached, follow(u, from + size, reached));
}

/* Derivatives of unknowns along a direction of knowns: continuous states and inputs. */
static int derivatives(unit *u, const unsigned *unknowns, size_t found, const unsigned *knowns,
                       size_t given, const double *seed, double *result) {
  enum { FURTHER_SEEDS = LINKAGE_STATE + INPUTS };
  double full[3 * N + FURTHER_SEEDS + N + STUCK + 1] = {0}, p[LINKAGE_PARAMETERS + 1];
  double first[N + MODES + STUCK + BLOCKS + 1], outputs[LINKAGE_QUANTITIES + 1];
  double *along = full + 3 * N;
  if (may(u, KNOWN, "derivatives") != OK || evaluate(u) != OK) return FAILED;
  fill(u, full);
  for (size_t k = 0; k < given; k++) {
    if (knowns[k] < FIRST_INPUT || knowns[k] >= FIRST_RATE) {
      return refuse(u, "no derivative by the variable with the reference %u is known", knowns[k]);
    }
    if (knowns[k] < FIRST_STATE) along[LINKAGE_STATE + knowns[k] - FIRST_INPUT] += seed[k];
    else along[STATE_ROWS[knowns[k] - FIRST_STATE]] += seed[k];
  }
  if (u->blind) return ended(u, u->s.t, u->blind);
  int status = derive(full, u->s.p, u->e.timed, first);
  for (int k = 0; k < N && is_across(u); k++) first[k] = 0.0; /* functions of time there */
  for (int k = 0; k < N; k++) along[FURTHER_SEEDS + k] = first[k];
  for (int k = 0; k < STUCK; k++) {
    const int stuck = u->s.p[HELD + STUCK_MODES[k]] == 0.0;
    along[FURTHER_SEEDS + N + k] = stuck ? first[N + MODES + k] : 0.0;
  }
  if (!status) status = replace_stuck(full, u->s.p, &u->e, p);
  if (!status) status = derive_outputs(full, p, u->e.timed, outputs);
  if (status) return ended(u, u->s.t, status);
  for (size_t k = 0; k < found; k++) {
    const unsigned of = unknowns[k];
    if (of >= FIRST_RATE && of < FIRST_INDICATOR) {
      const int row = STATE_ROWS[of - FIRST_RATE];
      result[k] = row < N ? along[N + row] : first[row - N];
    } else if (of >= FIRST_INDICATOR && of < FIRST_MARGIN) {
      const int j = (int)of - FIRST_INDICATOR;
      result[k] = is_across(u) ? 0.0 : turned(u, j) * first[N + j];
    } else if (of >= FIRST_MARGIN && of < FIRST_OUTPUT) {
      const int j = (int)of - FIRST_MARGIN;
      const double near = change_point_near(u, j), side = u->e.work[MARGIN + j] < 0.0 ? -1.0 : 1.0;
      result[k] = fabs(near) == 1.0 ? 0.0 : side * first[N + MODES + STUCK + j] / SCALES[j];
    } else if (of >= FIRST_OUTPUT && of < FIRST_MODE) {
      result[k] = outputs[of - FIRST_OUTPUT];
    } else {
      return refuse(u, "no derivative of the variable with the reference %u is known", of);
    }
  }
  return OK;
}

static void reset(unit *u) {
  unit_state *s = &u->s;
  const int exchange = s->exchange;
  memset(s, 0, sizeof *s);
  memcpy(s->token, TOKEN, sizeof TOKEN);
  s->exchange = exchange;
  s->phase = INSTANTIATED;
  s->tolerance = TOLERANCE;
  s->stale = 1;
  for (int k = 0; k < LINKAGE_NUMBERS; k++) s->numbers[k] = linkage_numbers[k];
  memset(&u->m, 0, sizeof u->m);
  u->m.p = s->p;
  changed(u);
}

static unit *instantiate(const char *name, const char *token, int exchange, unit_log log,
                         void *environment) {
  unit *u = calloc(1, sizeof *u);
  if (u == NULL) return NULL;
  u->log = log;
  u->environment = environment;
  u->name = calloc(1, strlen(name ? name : "") + 1);
  if (u->name != NULL && name != NULL) strcpy(u->name, name);
  u->s.exchange = exchange;
  reset(u);
  if (u->name != NULL && token != NULL && strcmp(token, TOKEN) == 0) return u;
  refuse(u, "found the token %s; expected %s", token ? token : "NULL", TOKEN);
  free(u->name);
  free(u);
  return NULL;
}

static int restored(unit *u, const unit_state *state) {
  if (memcmp(state->token, TOKEN, sizeof TOKEN) != 0 || state->exchange != u->s.exchange) {
    return refuse(u, "found a state of another unit or of another kind of simulation");
  }
  u->s = *state;
  memset(&u->m, 0, sizeof u->m);
  u->m.p = u->s.p;
  changed(u);
  return OK;
}
