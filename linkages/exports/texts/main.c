#ifndef LINKAGE_WITHOUT_MAIN

static void print_row(double t, const double *y, const double *p, void *data) {
  double out[LINKAGE_QUANTITIES + 1];
  int *failed = data;
  const int status = linkage_outputs(t, y, p, out);
  if (status) *failed = status;
  printf("%.17g", t);
  for (int k = 0; k < LINKAGE_QUANTITIES; k++) printf(",%.17g", status ? NAN : out[k]);
  printf("\n");
}

static int usage(const char *program) {
  fprintf(stderr,
          "usage: %s [--end S] [--samples N] [--method dop853|rk4] [--rtol R] [--atol A]\n"
          "       [--step S] [PATH=VALUE ...]\n"
          "Prints outputs as comma-separated values. Numbers of the definition file, in SI:\n",
          program);
  for (int k = 0; k < LINKAGE_NUMBERS; k++) {
    fprintf(stderr, "  %s=%.17g\n", linkage_paths[k], linkage_numbers[k]);
  }
  return 2;
}

/* The number after the first `begin` characters of a text; 0 if there is none. */
static int number(const char *text, size_t begin, double *value) {
  char *end;
  *value = strtod(text + begin, &end);
  return end != text + begin && *end == '\0';
}

int main(int count, char **texts) {
  double numbers[LINKAGE_NUMBERS + 1], p[LINKAGE_PARAMETERS + 1], y[LINKAGE_STATE + 1];
  double end = @END@, samples = @SAMPLES@, reached = 0.0;
  linkage_options options = {"dop853", @STEP@, 1e-10, 1e-12};
  for (int k = 0; k < LINKAGE_NUMBERS; k++) numbers[k] = linkage_numbers[k];
  for (int i = 1; i < count; i++) {
    const char *text = texts[i], *value = i + 1 < count ? texts[i + 1] : "";
    int known = 0;
    for (int k = 0; !known && k < LINKAGE_NUMBERS; k++) {
      const size_t length = strlen(linkage_paths[k]);
      if (strncmp(text, linkage_paths[k], length) == 0 && text[length] == '=') {
        known = number(text, length + 1, &numbers[k]);
      }
    }
    if (known) continue;
    if (strcmp(text, "--method") == 0) {
      options.method = value;
      known = strcmp(value, "dop853") == 0 || strcmp(value, "rk4") == 0;
    } else {
      const char *const flags[] = {"--end", "--samples", "--step", "--rtol", "--atol"};
      double *const places[] = {&end, &samples, &options.step, &options.rtol, &options.atol};
      for (int k = 0; k < 5; k++) {
        if (strcmp(text, flags[k]) == 0) known = number(value, 0, places[k]);
      }
    }
    if (!known) return usage(texts[0]);
    i += 1;
  }
  if (!(samples >= 2.0 && samples <= 1e8 && options.step > 0.0 && options.rtol > 0.0)) {
    return usage(texts[0]);
  }
  double *times = malloc((size_t)samples * sizeof *times);
  if (times == NULL) return 1;
  for (int k = 0; k < (int)samples; k++) times[k] = end * k / ((int)samples - 1);
  int failed = 0, status = linkage_start(numbers, p, y);
  if (!status) {
    printf("time");
    for (int k = 0; k < LINKAGE_QUANTITIES; k++) printf(",%s", linkage_names[k]);
    printf("\n");
    status = linkage_integrate(p, y, times, (int)samples, &options, print_row, &failed, &reached);
  }
  free(times);
  if (!status) status = failed;
  if (status) fprintf(stderr, "at t = %.9g s, %s\n", reached, linkage_message(status));
  return status ? 1 : 0;
}

#endif
