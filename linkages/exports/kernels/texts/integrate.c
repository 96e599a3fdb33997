#define LEAST_TOLERANCE 1e-300 /* so that what is and stays zero has no error */

typedef struct {
  double *p;
  double t, y[LINKAGE_STATE + 1], next[LINKAGE_STATE + 1], trial[LINKAGE_STATE + 1];
  double slopes[END + 1 + FURTHER][LINKAGE_STATE + 1];
} motion;

/* Slopes at a part of a step, from weighted slopes before it. */
static int stage(motion *m, int row, const double *weights, int count, double h, double at) {
  for (int i = 0; i < LINKAGE_STATE; i++) m->trial[i] = m->y[i];
  for (int j = 0; j < count; j++) {
    for (int i = 0; i < LINKAGE_STATE; i++) m->trial[i] += h * weights[j] * m->slopes[j][i];
  }
  return linkage_rates(m->t + at * h, m->trial, m->p, m->slopes[row]);
}

/* All stages of a step of dop853. */
static int tried(motion *m, double h) {
  for (int row = 1; row < END; row++) {
    const int status = stage(m, row, dop853_a[row], row, h, dop853_c[row]);
    if (status) return status;
  }
  const int status = stage(m, END, dop853_b, END, h, 1.0);
  for (int i = 0; i < LINKAGE_STATE; i++) m->next[i] = m->trial[i];
  return status;
}

/* Error of a step in units of what is allowed. */
static double error_of(const motion *m, double h, const linkage_options *options) {
  double sums[2] = {0.0, 0.0};
  for (int i = 0; i < LINKAGE_STATE; i++) {
    const double size = fmax(fabs(m->y[i]), fabs(m->next[i]));
    for (int e = 0; e < 2; e++) {
      double found = 0.0;
      for (int j = 0; j <= END; j++) found += dop853_error[e][j] * m->slopes[j][i];
      found /= fmax(options->atol, LEAST_TOLERANCE) + options->rtol * size;
      sums[e] += found * found;
    }
  }
  if (sums[0] == 0.0) return 0.0;
  return fabs(h) * sums[0] / sqrt((sums[0] + 0.01 * sums[1]) * LINKAGE_STATE);
}

/* The state at a part of a step, from all stages. */
static void between(motion *m, double h, double part) {
  for (int i = 0; i < LINKAGE_STATE; i++) m->trial[i] = m->y[i];
  for (int j = 0; j < END + 1 + FURTHER; j++) {
    double weight = 0.0;
    for (int k = POWERS - 1; k >= 0; k--) weight = (weight + dop853_dense[j][k]) * part;
    for (int i = 0; i < LINKAGE_STATE; i++) m->trial[i] += h * weight * m->slopes[j][i];
  }
}

static double first_step(const motion *m, const linkage_options *options) {
  double position = 0.0, slope = 0.0;
  for (int i = 0; i < LINKAGE_STATE; i++) {
    const double scale = fmax(options->atol, LEAST_TOLERANCE) + options->rtol * fabs(m->y[i]);
    position += m->y[i] / scale * (m->y[i] / scale);
    slope += m->slopes[0][i] / scale * (m->slopes[0][i] / scale);
  }
  return position > 1e-10 && slope > 1e-10 ? 0.01 * sqrt(position / slope) : 1e-6;
}

/* Further stages for dense output, once for a step. */
static int prepared(motion *m, double h, int *done) {
  for (int k = 0; !*done && k < FURTHER; k++) {
    const int row = END + 1 + k;
    const int status = stage(m, row, dop853_further_a[k], row, h, dop853_further_c[k]);
    if (status) return status;
  }
  *done = 1;
  return 0;
}

/* The mode that changes first within a step, and the part of the step just behind that: of 8 places
   the first that contradicts a mode, then bisection. -1 if none does. */
static int first_change(motion *m, double h, double *part) {
  double low = 0.0, high = 0.0;
  int mode = -1;
  for (int k = 1; k <= 8 && mode < 0; k++) {
    low = high;
    high = k / 8.0;
    between(m, h, high);
    mode = contradicted(m->t + high * h, m->trial, m->p);
  }
  for (int k = 0; mode >= 0 && k < 60; k++) {
    const double middle = 0.5 * (low + high);
    if (middle == low || middle == high) break;
    between(m, h, middle);
    const int found = contradicted(m->t + middle * h, m->trial, m->p);
    if (found < 0) {
      low = middle;
    } else {
      high = middle;
      mode = found;
    }
  }
  *part = high;
  return mode;
}

/* Dormand and Prince's method of order 8 (Hairer, Nørsett, Wanner: Solving Ordinary Differential
   Equations I, II.5, II.6 and II.10). */
static int adaptive(motion *m, const double *times, int count, const linkage_options *options,
                    linkage_visit visit, void *data) {
  const double last = times[count - 1], sign = last < m->t ? -1.0 : 1.0;
  double h = sign * first_step(m, options);
  double since = m->t;
  int index = 0, rejected = 0, changes = 0;
  for (; index < count && times[index] == m->t; index++) visit(m->t, m->y, m->p, data);
  while (sign * (last - m->t) > 0.0) {
    const int final = sign * (m->t + 1.01 * h - last) > 0.0;
    if (final) h = last - m->t;
    if (fabs(h) < 1e-14 * fmax(fabs(m->t), 1e-3)) return STEP_TOO_SMALL;
    int status = tried(m, h);
    const double error = status ? HUGE_VAL : error_of(m, h, options);
    if (!(error <= 1.0)) {
      h *= error < HUGE_VAL ? fmax(1.0 / 3.0, 0.9 * pow(error, -0.125)) : 0.25;
      if (status && fabs(h) < 1e-14 * fmax(fabs(m->t), 1e-3)) return status;
      rejected = 1;
      continue;
    }
    double reached = final ? last : m->t + h, part = 1.0;
    int done = 0, mode = -1;
    if (MODES) {
      status = prepared(m, h, &done);
      if (status) return status;
      mode = first_change(m, h, &part);
    }
    if (mode >= 0) {
      reached = m->t + part * h;
      between(m, h, part);
      for (int i = 0; i < LINKAGE_STATE; i++) m->next[i] = m->trial[i];
    }
    for (; index < count && sign * (times[index] - reached) <= 0.0; index++) {
      if (times[index] == reached) {
        for (int i = 0; i < LINKAGE_STATE; i++) m->trial[i] = m->next[i];
      } else {
        status = prepared(m, h, &done);
        if (status) return status;
        between(m, h, (times[index] - m->t) / h);
      }
      status = linkage_settle(times[index], m->trial, m->p);
      if (status) return status;
      visit(times[index], m->trial, m->p, data);
    }
    for (int i = 0; i < LINKAGE_STATE; i++) m->y[i] = m->next[i];
    m->t = reached;
    status = linkage_settle(m->t, m->y, m->p);
    if (!status && mode >= 0) {
      status = change(mode, m->t, m->y, m->p);
      changes = m->t - since > 1e-10 * fabs(m->t) ? 1 : changes + 1;
      if (changes == 1) since = m->t;
      if (changes > 100) return STEP_TOO_SMALL;
    }
    if (!status) status = linkage_rates(m->t, m->y, m->p, m->slopes[0]);
    if (status) return status;
    const double growth = error > 0.0 ? fmin(6.0, 0.9 * pow(error, -0.125)) : 6.0;
    h *= rejected ? fmin(1.0, growth) : growth;
    rejected = 0;
  }
  return 0;
}

/* The classical method of order 4: equal steps from each time to the next. */
static int fixed(motion *m, const double *times, int count, const linkage_options *options,
                 linkage_visit visit, void *data) {
  static const double half[] = {0.5}, other[] = {0.0, 0.5}, whole[] = {0.0, 0.0, 1.0};
  static const double all[] = {1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0};
  for (int index = 0; index < count; index++) {
    const double begin = m->t, span = times[index] - begin;
    const double needed = ceil(fabs(span) / options->step);
    for (double k = 0.0; k < needed; k += 1.0) {
      const double h = span / needed;
      int status = linkage_rates(m->t, m->y, m->p, m->slopes[0]);
      if (!status) status = stage(m, 1, half, 1, h, 0.5);
      if (!status) status = stage(m, 2, other, 2, h, 0.5);
      if (!status) status = stage(m, 3, whole, 3, h, 1.0);
      if (!status) status = stage(m, 4, all, 4, h, 1.0);
      if (status) return status;
      for (int i = 0; i < LINKAGE_STATE; i++) m->y[i] = m->trial[i];
      m->t = k + 1.0 < needed ? begin + (k + 1.0) * h : times[index];
      status = linkage_settle(m->t, m->y, m->p);
      if (status) return status;
    }
    visit(m->t, m->y, m->p, data);
  }
  return 0;
}

/* Whether drives lead a block through a singular position: intervals are halved until margins change
   little in each, and where one is least. */
static int led_through(const double *p, const double *y, double a, const evaluation *ea, double b,
                       const evaluation *eb, int depth, double *where) {
  int split = 0;
  for (int k = 0; k < BLOCKS; k++) {
    const int margin = FUNCTION + 2 * MODES + k, rate = margin + BLOCKS;
    const double from = ea->work[margin] * ea->work[rate] * (b - a);
    const double to = eb->work[margin] * eb->work[rate] * (b - a);
    const double change = fmax(fabs(ea->work[rate]), fabs(eb->work[rate])) * fabs(b - a);
    if (fabs(eb->work[margin]) < 1e-7 * margin_scale[k]) {
      *where = b;
      return SINGULAR + blocks[k];
    }
    split = split || change > 0.35 * margin_scale[k] || (from < 0.0 && to > 0.0);
  }
  const double middle = 0.5 * (a + b);
  if (!split || depth == 40) return 0;
  evaluation e;
  *where = middle;
  int status = look(middle, y, p, &e);
  if (!status) status = led_through(p, y, a, ea, middle, &e, depth + 1, where);
  return status ? status : led_through(p, y, middle, &e, b, eb, depth + 1, where);
}

/* Visits all times of a motion that drives determine. */
static int driven(motion *m, const double *times, int count, linkage_visit visit, void *data) {
  evaluation before, here;
  for (int k = 0; k < count; k++) {
    double where = times[k];
    int status = look(times[k], m->y, m->p, &here);
    if (k > 0 && !status) {
      status = led_through(m->p, m->y, m->t, &before, times[k], &here, 0, &where);
    }
    m->t = status ? where : times[k];
    if (status) return status;
    visit(m->t, m->y, m->p, data);
    before = here;
  }
  return 0;
}

int linkage_integrate(double *p, double *y, const double *times, int count,
                      const linkage_options *options, linkage_visit visit, void *data,
                      double *reached) {
  motion m = {0};
  m.p = p;
  m.t = times[0];
  for (int i = 0; i < LINKAGE_STATE; i++) m.y[i] = y[i];
  const int equal = strcmp(options->method, "rk4") == 0;
  const int back = times[count - 1] < times[0];
  int status = MODES && (equal || back) ? NOT_FOLLOWED : linkage_settle(m.t, m.y, p);
  if (!status) status = linkage_rates(m.t, m.y, p, m.slopes[0]);
  if (!status && !LINKAGE_STATE) {
    status = driven(&m, times, count, visit, data);
  } else if (!status) {
    status = (equal ? fixed : adaptive)(&m, times, count, options, visit, data);
  }
  for (int i = 0; i < LINKAGE_STATE; i++) y[i] = m.y[i];
  *reached = m.t;
  return status;
}
