/* A product of two doubles is the sum of two doubles, p = fl(a u) and fma(a, u, -p) (Dekker, Numer.
 * Math. 18, 1971). Sums are kept as expansions: doubles that do not overlap, smallest first, whose
 * exact sum is meant and whose sign is that of the last (Shewchuk, Discrete Comput. Geom. 18, 1997,
 * Grow-Expansion with zeros left out). */
#include "exact.h"

#include <math.h>
#include <stddef.h>

/* Nonadjacent doubles hold at least two of the 2098 binary places each. */
enum { LONGEST = 1056 };

typedef struct expansion {
  double part[LONGEST];
  int size;
} expansion;

static void add(expansion *e, double value)
{
  int size = 0;
  for (int i = 0; i < e->size; i++) { /* sum + error = value + part, exactly */
    double part = e->part[i], sum = value + part;
    double shadow = sum - value, error = (value - (sum - shadow)) + (part - shadow);
    if (error != 0) e->part[size++] = error;
    value = sum;
  }
  if (value != 0) e->part[size++] = value;
  e->size = size;
}

int nsdae_exact_sign(int n, const double *a, int stride, const double *u)
{
  expansion e = {.size = 0};
  for (int i = 0; i < n; i++) {
    double factor = a[(size_t)i * (size_t)stride], product = factor * u[i];
    if (factor == 0 || u[i] == 0) continue;
    if (!(fabs(product) > 0x1p-900 && fabs(product) < 0x1p900)) return NSDAE_SIGN_UNKNOWN;
    add(&e, fma(factor, u[i], -product));
    add(&e, product);
  }
  if (e.size == 0) return 0;
  return e.part[e.size - 1] > 0 ? 1 : -1;
}
