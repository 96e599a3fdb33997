/* A slider-crank at 5000 rpm whose pin may leave its hole, by hand: the yardstick for contact.
 *
 *   ./slidercrank_contact END RTOL LOCATED [EVENTS]
 *
 * Integrates the offset of tests/data/contact/4-slider-crank-5000rpm.json with DOP853 to END seconds.
 * With LOCATED 1 every touch, leave and slack is located and ends a step. With 0 steps go over them,
 * forces follow the sign of the depth, and the first rate is that at the end of the step. Prints offset, rate, velocity of the
 * slider, evaluations, those of them for location, touches and seconds; events if asked for.
 * dop853.h holds the method's sums of stages; contact_in_c.py writes it from its coefficients.
 */
#define _GNU_SOURCE
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "dop853.h"

enum { FREE, CONTACT, SLACK };

static const double crank = 0.05, rod = 0.12, centre = 0.06, rod_mass = 0.21, slider_mass = 0.14;
static const double rod_moment = 0.00025 + 0.21 * 0.06 * 0.06, omega = 5000 * M_PI / 30;
static const double size = 0.5e-3, stiffness = 6.61e10, damping = 0.75 * (1 - 0.81), least = 1e-3;

static int mode, located;
static double first_rate = 1;
static long evaluations;

typedef struct { double depth, rate, factor; } wall;

static inline wall wall_of(const double *y) {
  double rho = sqrt(y[0] * y[0] + y[1] * y[1]), rate = rho > 0 ? (y[0] * y[2] + y[1] * y[3]) / rho : 0;
  return (wall){rho - size, rate, 1 + damping * rate / first_rate};
}

/* Offset e = end of the rod - slider: sin of the rod's angle from e.y, the slider from e.x. */
static inline void rates(double t, const double *y, double *out) {
  double s, c, Fx = 0, Fy = 0;
  sincos(omega * t, &s, &c);
  double Ax = crank * c, Ay = crank * s, ax = -omega * omega * Ax, ay = -omega * omega * Ay;
  double ls = y[1] - Ay, lc = sqrt(rod * rod - ls * ls), k = 1 / lc, tangent = ls * k;
  double spin = (y[3] - omega * Ax) * k, spin2 = spin * spin;
  double turn = k * (ls * spin2 - ay); /* angular acceleration of the rod while e has none */
  double slide = ax - lc * spin2 - ls * turn;
  if (located ? mode == CONTACT : y[0] * y[0] + y[1] * y[1] > size * size) {
    double rho = sqrt(y[0] * y[0] + y[1] * y[1]), inverse = 1 / rho, d = fmax(rho - size, 0);
    double rate = (y[0] * y[2] + y[1] * y[3]) * inverse;
    double force = stiffness * d * sqrt(d) * fmax(1 + damping / first_rate * rate, 0) * inverse;
    Fx = -force * y[0];
    Fy = -force * y[1];
  }
  double weighed = rod_moment * turn + rod_mass * (centre / rod) * (lc * ay - ls * ax);
  out[0] = y[2];
  out[1] = y[3];
  out[3] = (Fy - tangent * Fx) / (rod_moment * k * k) - weighed / (rod_moment * k);
  out[2] = Fx / slider_mass + slide - tangent * out[3];
}

static double slider_velocity(double t, const double *y) {
  double Ax = crank * cos(omega * t), Ay = crank * sin(omega * t);
  double ls = y[1] - Ay, lc = sqrt(rod * rod - ls * ls);
  return -omega * Ay - ls * (y[3] - omega * Ax) / lc - y[2];
}

#define STAGE(j)                                                                   \
  for (int i = 0; i < 4; i++) w[i] = y[i] + h * (SUM_##j);                         \
  rates(t + C_##j * h, w, k[j]);

/* One step from y with k[0] known; k[12] is the rate at its end. */
static void step(double t, const double *y, double h, double (*k)[4], double *new) {
  double w[4];
  STAGE(1) STAGE(2) STAGE(3) STAGE(4) STAGE(5) STAGE(6)
  STAGE(7) STAGE(8) STAGE(9) STAGE(10) STAGE(11)
  for (int i = 0; i < 4; i++) new[i] = y[i] + h * (SUM_12);
  evaluations += 11;
}

static double error_of(double (*k)[4], double h, const double *y, const double *new, double rtol) {
  const double atol[4] = {size, size, size * omega, size * omega};
  double five = 0, three = 0;
  for (int i = 0; i < 4; i++) {
    double scale = 1 / (rtol * (0.1 * atol[i] + fmax(fabs(y[i]), fabs(new[i]))));
    five += (ERROR_5) * (ERROR_5) * scale * scale;
    three += (ERROR_3) * (ERROR_3) * scale * scale;
  }
  return five == 0 ? 0 : h * five / sqrt(4 * (five + 0.01 * three));
}

/* The share of a step after which one of the guards is crossed, by cubics; 2 where none is. */
static double cubic(double s, double a, double da, double b, double db) {
  double r = 1 - s;
  return r * r * ((1 + 2 * s) * a + s * da) + s * s * ((3 - 2 * s) * b - r * db);
}

static double crossing(double sign, double a, double da, double b, double db) {
  double low = 0, high = 1;
  a *= sign, da *= sign, b *= sign, db *= sign;
  if (a < 0) a = 0; /* just crossed: round-off */
  if (b > 0) {
    if (da >= 0 || db <= 0) return 2; /* it stays away, or has no minimum within */
    double left = 0, right = 1;
    for (int i = 0; i < 30; i++) {
      double m = left + (right - left) / 3, n = right - (right - left) / 3;
      if (cubic(m, a, da, b, db) < cubic(n, a, da, b, db)) right = n; else left = m;
    }
    if (cubic(left, a, da, b, db) >= 0) return 2;
    high = left;
  } else if (a == 0 && da < 0) {
    return 2; /* on its way across: the change has just been made */
  }
  if (a == 0) { /* leaves zero first: look behind the hump */
    low = 1e-6;
    if (cubic(low, a, da, b, db) < 0) return 2;
  }
  for (int i = 0; i < 60; i++) {
    double middle = 0.5 * (low + high);
    if (cubic(middle, a, da, b, db) > 0) low = middle; else high = middle;
  }
  return high;
}

/* The earliest crossing: what is crossed (0 depth, 1 factor), and after which share of the step. */
static double earliest(const double *y, const double *k, const double *new, const double *l,
                       double h, int *what) {
  wall a = wall_of(y), b = wall_of(new);
  double share = crossing(mode == FREE ? -1 : 1, a.depth, h * a.rate, b.depth, h * b.rate);
  *what = 0;
  if (mode != FREE) {
    double slope = damping / first_rate * h, ra = hypot(y[0], y[1]), rb = hypot(new[0], new[1]);
    double da = (k[2] * y[0] + k[3] * y[1] + y[2] * y[2] + y[3] * y[3] - a.rate * a.rate) / ra;
    double db = (l[2] * new[0] + l[3] * new[1] + new[2] * new[2] + new[3] * new[3] -
                 b.rate * b.rate) / rb;
    double sign = mode == CONTACT ? 1 : -1;
    double other = crossing(sign, a.factor, slope * da, b.factor, slope * db);
    if (other < share) share = other, *what = 1;
  }
  return share;
}

/* After a touch: a twentieth of the time that its compression takes. */
static double change(const double *y, double t, int what, double h) {
  wall at = wall_of(y);
  if (what == 1) {
    mode = mode == CONTACT ? SLACK : CONTACT;
    return 0.1 * h;
  }
  if (mode != FREE) {
    mode = FREE;
    return h;
  }
  mode = CONTACT;
  first_rate = fmax(at.rate, least);
  double ls = y[1] - crank * sin(omega * t), k2 = 1 / (rod * rod - ls * ls), rho = hypot(y[0], y[1]);
  double nx = y[0] / rho, across = y[1] / rho - sqrt(k2) * ls * nx;
  double mass = 1 / (nx * nx / slider_mass + across * across / (rod_moment * k2));
  return 0.05 * pow(mass * at.rate * at.rate / stiffness, 0.4) / fmax(at.rate, 1e-6);
}

int main(int count, char **arguments) {
  double end = atof(arguments[1]), rtol = atof(arguments[2]), t = 0, h = 1e-6;
  int shown = count > 4;
  located = atoi(arguments[3]);
  double y[4] = {0}, new[4], k[13][4];
  long touches = 0, locating = 0;
  struct timespec begin, finish;
  clock_gettime(CLOCK_MONOTONIC, &begin);
  rates(t, y, k[0]), evaluations++;
  double grown = 6;
  while (t < end) {
    if (mode == FREE) {
      wall at = wall_of(y);
      h = fmin(h, fmax(size / (4 * fabs(at.rate) + 1e-9), 1e-9));
    }
    h = fmin(h, end - t);
    step(t, y, h, k, new);
    double error = error_of(k, h, y, new, rtol);
    if (!(error <= 1)) {
      h *= fmax(0.2, 0.9 * pow(error, -0.125)), grown = 1;
      if (!(h > 0)) return 1;
      continue;
    }
    double next = h * fmin(grown, error > 0 ? 0.9 * pow(error, -0.125) : grown);
    int what;
    rates(t + h, new, k[12]), evaluations++;
    double share = earliest(y, k[0], new, k[12], h, &what);
    if (share <= 1 && located) {
      long before = evaluations;
      double part = share * h;
      for (int i = 0; i < 8; i++) {
        step(t, y, part, k, new);
        rates(t + part, new, k[12]), evaluations++;
        wall at = wall_of(new);
        double value = at.depth, slope = at.rate;
        if (what == 1) {
          double rho = hypot(new[0], new[1]);
          slope = damping / first_rate * (k[12][2] * new[0] + k[12][3] * new[1] +
                  new[2] * new[2] + new[3] * new[3] - at.rate * at.rate) / rho;
          value = at.factor;
        }
        double by = -value / slope;
        if (fabs(what ? value * size : value) < 1e-2 * rtol * size) break;
        part = fmin(fmax(part + by, 1e-12 * h), h);
      }
      locating += evaluations - before;
      h = part;
    }
    t += h;
    memcpy(y, new, sizeof y);
    memcpy(k[0], k[12], sizeof k[0]);
    h = next, grown = 6;
    if (share <= 1) {
      if (shown) printf("%.16g %s\n", t, what ? "slack" : mode == FREE ? "touch" : "leave");
      touches += what == 0 && mode == FREE;
      h = change(y, t, what, h);
      rates(t, y, k[0]), evaluations++;
    }
  }
  clock_gettime(CLOCK_MONOTONIC, &finish);
  double seconds = (finish.tv_sec - begin.tv_sec) + 1e-9 * (finish.tv_nsec - begin.tv_nsec);
  printf("%.16g %.16g %.16g %.16g %.16g %ld %ld %ld %.9f\n", y[0], y[1], y[2], y[3],
         slider_velocity(t, y), evaluations, locating, touches, seconds);
  return 0;
}
