typedef struct {
  const double *p;
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
      found /= options->atol + options->rtol * size;
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
    const double scale = options->atol + options->rtol * fabs(m->y[i]);
    position += m->y[i] / scale * (m->y[i] / scale);
    slope += m->slopes[0][i] / scale * (m->slopes[0][i] / scale);
  }
  return position > 1e-10 && slope > 1e-10 ? 0.01 * sqrt(position / slope) : 1e-6;
}

/* Dormand and Prince's method of order 8 (Hairer, Nørsett, Wanner: Solving Ordinary Differential
   Equations I, II.5, II.6 and II.10). */
static int adaptive(motion *m, const double *times, int count, const linkage_options *options,
                    linkage_visit visit, void *data) {
  const double last = times[count - 1], sign = last < m->t ? -1.0 : 1.0;
  double h = sign * first_step(m, options);
  int index = 0, rejected = 0;
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
    const double reached = final ? last : m->t + h;
    for (int prepared = 0; index < count && sign * (times[index] - reached) <= 0.0; index++) {
      for (int k = 0; !prepared && times[index] != reached && k < FURTHER; k++) {
        status = stage(m, END + 1 + k, dop853_further_a[k], END + 1 + k, h, dop853_further_c[k]);
        if (status) return status;
      }
      if (times[index] == reached) {
        for (int i = 0; i < LINKAGE_STATE; i++) m->trial[i] = m->next[i];
      } else {
        prepared = 1;
        between(m, h, (times[index] - m->t) / h);
      }
      status = linkage_settle(times[index], m->trial, m->p);
      if (status) return status;
      visit(times[index], m->trial, m->p, data);
    }
    for (int i = 0; i < LINKAGE_STATE; i++) m->y[i] = m->next[i];
    m->t = reached;
    status = linkage_settle(m->t, m->y, m->p);
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

int linkage_integrate(const double *p, double *y, const double *times, int count,
                      const linkage_options *options, linkage_visit visit, void *data,
                      double *reached) {
  motion m = {0};
  m.p = p;
  m.t = times[0];
  for (int i = 0; i < LINKAGE_STATE; i++) m.y[i] = y[i];
  int status = MODES ? MODES_CHANGE : linkage_settle(m.t, m.y, p);
  if (!status) status = linkage_rates(m.t, m.y, p, m.slopes[0]);
  if (!status && !LINKAGE_STATE) {
    for (int k = 0; !status && k < count; k++) {
      m.t = times[k];
      status = linkage_settle(m.t, m.y, p);
      if (!status) visit(m.t, m.y, p, data);
    }
  } else if (!status) {
    status = (strcmp(options->method, "rk4") == 0 ? fixed : adaptive)(&m, times, count, options,
                                                                      visit, data);
  }
  for (int i = 0; i < LINKAGE_STATE; i++) y[i] = m.y[i];
  *reached = m.t;
  return status;
}
