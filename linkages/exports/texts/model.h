#ifndef LINKAGE_H
#define LINKAGE_H

#ifdef __cplusplus
extern "C" {
#endif

enum {
  LINKAGE_NUMBERS = @NUMBERS@,       /* of the definition file, which may be changed */
  LINKAGE_PARAMETERS = @PARAMETERS@, /* of the equations, and what is prepared of them */
  LINKAGE_STATE = @STATE@,           /* coordinates (angles in rad, positions in m), then
                                their rates (per s) */
  LINKAGE_QUANTITIES = @QUANTITIES@  /* outputs */
};

extern const char *const linkage_paths[];      /* of numbers in the definition file */
extern const double linkage_numbers[];         /* as the definition file has them, in SI */
extern const char *const linkage_names[];      /* of outputs */
extern const char *const linkage_units[];      /* of outputs */
extern const char *const linkage_coordinates[]; /* of the state, in its order */

/* All functions return 0, or a status that linkage_message explains. */
const char *linkage_message(int status);

/* Parameters and initial state from numbers of the definition file. */
int linkage_start(const double *numbers, double *p, double *y);

/* Replaces coordinates that follow from others without a closed form by those that close all
   loops, from values that are about right. */
int linkage_settle(double t, double *y, const double *p);

/* Derivatives of the state. */
int linkage_rates(double t, const double *y, const double *p, double *out);

/* Outputs in the order of their names. */
int linkage_outputs(double t, const double *y, const double *p, double *out);

typedef struct {
  const char *method; /* "dop853" (adaptive, order 8) or "rk4" (of fixed steps) */
  double step;        /* of rk4, at most, in s */
  double rtol, atol;  /* of dop853 */
} linkage_options;

/* Is told of the state at a time. */
typedef void (*linkage_visit)(double t, const double *y, const double *p, void *data);

/* Follows a motion from times[0], through contacts, friction and, where the definition says so, change
   points; y becomes the last state that was reached, *reached its time, and modes in p, of contacts, friction and assembly, those that it has there. */
int linkage_integrate(double *p, double *y, const double *times, int count,
                      const linkage_options *options, linkage_visit visit, void *data,
                      double *reached);

#ifdef __cplusplus
}
#endif

#endif
