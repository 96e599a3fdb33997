/* Modes, of contacts and friction, stand in p from HELD on, then what is remembered of changes. */

typedef struct {
  double timed[TIMED + 1], work[WRITTEN + 1];
} evaluation;

static int look(double t, const double *y, const double *p, evaluation *e) {
  return evaluated(t, y, p, e->timed, e->work);
}

static double function_of(int k, const evaluation *e) { return e->work[FUNCTION + k]; }

static double rate_of(int k, const evaluation *e) { return e->work[FUNCTION + MODES + k]; }

static int is_watched(int k, const double *p) {
  return active[k] < 0 || p[HELD + active[k]] > 0.0;
}

static void remember(int k, const double *values, double *p) {
  for (int r = 0; r < MEMORIES; r++) {
    if (owners[r] == k) p[HELD + MODES + r] = values[r];
  }
}

/* Sets modes that follow from the state: all of them, or those behind one that has changed. */
static int wake(double t, const double *y, double *p, int behind) {
  evaluation e;
  double values[VALUES + 1];
  for (int k = 0; k < MODES; k++) {
    int owner = behind < 0 ? behind : active[k];
    while (owner >= 0 && owner != behind) owner = active[owner];
    if (owner != behind) continue;
    int status = look(t, y, p, &e);
    if (status) return status;
    const double value = function_of(k, &e);
    const int on = value > 0.0 || (value == 0.0 && rate_of(k, &e) >= 0.0);
    p[HELD + k] = is_watched(k, p) && on ? 1.0 : -1.0;
    if (behind < 0) {
      status = become(y, p, e.timed, values);
      if (status) return status;
      remember(k, values, p);
    }
  }
  return 0;
}

/* The first mode that a state contradicts, -1 if there is none; -2 if there is no such state. */
static int contradicted(double t, const double *y, const double *p) {
  evaluation e;
  if (look(t, y, p, &e)) return -2;
  for (int k = 0; k < MODES; k++) {
    const double mode = p[HELD + k] != 0.0 ? p[HELD + k] : 1.0;
    if (is_watched(k, p) && mode * function_of(k, &e) < 0.0) return k;
  }
  return -1;
}

/* A mode that stuck goes to the side to which its function leaves. */
static int take_side(int k, double t, const double *y, double *p) {
  evaluation e;
  p[HELD + k] = -1.0;
  int status = look(t, y, p, &e);
  const double down = -rate_of(k, &e);
  p[HELD + k] = 1.0;
  if (!status) status = look(t, y, p, &e);
  if (!status && rate_of(k, &e) < down) p[HELD + k] = -1.0;
  return status;
}

/* Changes a mode where its function has crossed zero, and what follows from that. */
static int change(int k, double t, double *y, double *p) {
  evaluation e;
  double values[VALUES + 1];
  int status = look(t, y, p, &e);
  if (!status) status = become(y, p, e.timed, values);
  if (status) return status;
  if (shakes[k]) return NOT_FOLLOWED;
  if (p[HELD + k] == 0.0) return take_side(k, t, y, p);
  const int rises = p[HELD + k] < 0.0, jumps_here = rises && jumps[k] >= 0;
  const double before = rate_of(k, &e);
  const int jumping = jumps_here && before > 0.0;
  if (!jumps_here || jumping) p[HELD + k] = -p[HELD + k];
  if (rises) remember(k, values, p);
  for (int i = 0; jumping && i < FIRST_CARRIED; i++) y[COORDINATES + i] = values[jumps[k] + i];
  status = linkage_settle(t, y, p);
  if (!status) status = look(t, y, p, &e);
  if (!status && jumping && rate_of(k, &e) < 0.0) p[HELD + k] = -1.0;
  if (!status) status = wake(t, y, p, k);
  if (!status) status = look(t, y, p, &e);
  if (!status && p[HELD + k] * rate_of(k, &e) < -1e-9 * fabs(before)) {
    if (!sticks[k]) return NOT_FOLLOWED;
    p[HELD + k] = 0.0;
    status = look(t, y, p, &e);
    if (!status && function_of(k, &e) < -1e-9) return NOT_FOLLOWED;
  }
  return status;
}

