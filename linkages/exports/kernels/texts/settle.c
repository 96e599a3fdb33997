/* Evaluates the equations: accelerations, then settled coordinates and their rates. */
static int evaluated(double t, const double *y, const double *p, double *timed, double *work) {
  const int status = clock_(t, p, timed);
  return status ? status : equations(y, p, timed, work);
}

int linkage_settle(double t, double *y, const double *p) {
  double timed[TIMED + 1], work[WRITTEN + 1];
  const int status = evaluated(t, y, p, timed, work);
  for (int k = 0; !status && k < CARRIED; k++) {
    y[FIRST_CARRIED + k] = work[COORDINATES + k];
    y[COORDINATES + FIRST_CARRIED + k] = work[COORDINATES + CARRIED + k];
  }
  return status;
}

