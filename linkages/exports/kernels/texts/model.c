int linkage_rates(double t, const double *y, const double *p, double *out) {
  double timed[TIMED + 1], work[WRITTEN + 1];
  const int status = evaluated(t, y, p, timed, work);
  for (int i = 0; i < COORDINATES; i++) {
    out[i] = i >= FREE && i < FIRST_CARRIED ? 0.0 : y[COORDINATES + i];
    out[COORDINATES + i] = work[i];
  }
  return status;
}

int linkage_outputs(double t, const double *y, const double *p, double *out) {
  double timed[TIMED + 1], work[WRITTEN + 1], full[3 * COORDINATES + 1];
  const int status = evaluated(t, y, p, timed, work);
  if (status) return status;
  for (int i = 0; i < 2 * COORDINATES; i++) full[i] = y[i];
  for (int i = 0; i < COORDINATES; i++) full[2 * COORDINATES + i] = work[i];
  return quantities(full, p, timed, out);
}

/* From numbers and a state whose dependent coordinates are about right. */
static int started(const double *numbers, double *p, double *y) {
  double timed[TIMED + 1], turns[TURNED + 1];
  int status = feed(numbers, p, y);
  if (status) return status;
  for (int k = 0; k < TURNED; k++) p[turned[k]] = 0.0;
  prepare(p);
  status = linkage_settle(0.0, y, p);
  if (!status && TURNED) {
    status = clock_(0.0, p, timed);
    if (!status) status = settle(y, p, timed, turns);
    for (int k = 0; k < TURNED; k++) p[turned[k]] = turns[k];
    prepare(p);
    if (!status) status = linkage_settle(0.0, y, p);
  }
  return status ? status : wake(0.0, y, p, -1);
}

int linkage_start(const double *numbers, double *p, double *y) {
  double between[LINKAGE_NUMBERS + 1];
  int status = 0;
  for (int steps = 1; steps <= 64; steps *= 4) {
    for (int i = 0; i < LINKAGE_PARAMETERS; i++) p[i] = parameters[i];
    for (int i = 0; i < LINKAGE_STATE; i++) y[i] = state[i];
    for (int k = 1; k <= steps; k++) {
      for (int i = 0; i < LINKAGE_NUMBERS; i++) {
        const double own = linkage_numbers[i];
        between[i] = k == steps ? numbers[i] : own + (numbers[i] - own) * k / steps;
      }
      status = started(between, p, y);
      if (status) break;
    }
    if (!status || !CARRIED) return status;
  }
  return status;
}
