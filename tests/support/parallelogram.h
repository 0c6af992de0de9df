/* A bar (1.2 kg, 1.6 m) hung on three or more equal cranks (0.4 kg, 0.5 m), all by absolute
 * coordinates: q = x, y, phi of each crank, which hangs at phi = 0, then of the bar. With n cranks
 * n - 2 of the 4 n constraints say nothing. It is a pendulum, phi'' = -p^2 sin(phi),
 * p^2 = (n m / 2 + M) g r / ((n m / 3 + M) r^2), that hits a stop where it hangs: x of the bar >=
 * 0. */
#ifndef PARALLELOGRAM_H
#define PARALLELOGRAM_H

#include <nsdae/nsdae.h>

enum { PARALLELOGRAM_CRANKS = 6, PARALLELOGRAM_NQ = 3 * PARALLELOGRAM_CRANKS + 3 };

typedef struct parallelogram {
  int cranks, given; /* given: second derivatives too, else they are differences */
  double e;
} parallelogram;

int parallelogram_nq(const parallelogram *p);
/* NULL without memory; keeps p. */
nsdae_system *parallelogram_system(parallelogram *p);
/* q [nq] with the cranks at phi. */
void parallelogram_start(const parallelogram *p, double phi, double *q);

/* p; and a quarter of the period of a swing to 2 asin(k), by Gauss's means. */
double parallelogram_frequency(const parallelogram *p);
double parallelogram_quarter(const parallelogram *p, double k);

#endif
