int linkage_settle(double t, double *y, const double *p) {
  evaluation e;
  return close_loops(t, y, p, &e);
}

int linkage_rates(double t, const double *y, const double *p, double *out) {
  evaluation e;
  return slopes_at(t, y, p, &e, out);
}

int linkage_outputs(double t, const double *y, const double *p, double *out) {
  evaluation e;
  return outputs_at(t, y, p, &e, out);
}

int linkage_start(const double *numbers, double *p, double *y) {
  evaluation e;
  return start_from(numbers, p, y, &e);
}

int linkage_integrate(double *p, double *y, const double *times, int count,
                      const linkage_options *options, linkage_visit visit, void *data,
                      double *reached) {
  motion m = {0};
  m.p = p;
  m.times = times;
  m.count = count;
  m.visit = visit;
  m.data = data;
  m.t = times[0];
  m.sign = times[count - 1] < times[0] ? -1.0 : 1.0;
  m.equal = strcmp(options->method, "rk4") == 0;
  m.longest = m.equal ? options->step : HUGE_VAL;
  m.rtol = options->rtol;
  m.atol = options->atol;
  for (int i = 0; i < LINKAGE_STATE; i++) m.y[i] = y[i];
  const int status = moved(&m);
  for (int i = 0; i < LINKAGE_STATE; i++) y[i] = m.y[i];
  *reached = m.t;
  return status;
}
