/* A product of two doubles is the sum of two doubles, p = fl(a u) and fma(a, u, -p) (Dekker, Numer.
 * Math. 18, 1971). Sums are kept as expansions: doubles that do not overlap, smallest first, whose
 * exact sum is meant and whose sign is that of the last (Shewchuk, Discrete Comput. Geom. 18, 1997,
 * Grow-Expansion with zeros left out). */
#include "separation.h"

#include <math.h>
#include <stddef.h>

#include "vector.h"

/* Nonadjacent doubles hold at least two of the 2098 binary places each. */
enum { LONGEST = 1056 };

typedef struct expansion {
  double part[LONGEST];
  int size;
} expansion;

static void add_exactly(expansion *e, double value)
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

/* Sum of the exponents of the factors, or NONE where one is zero. */
enum { NONE = -10000, SPAN = 900 };

static int power_of(double a, double u)
{
  return a == 0 || u == 0 ? NONE : ilogb(a) + ilogb(u);
}

void nsdae_to_integers(int n, double *w)
{
  enum { LARGEST = 4096 };
  double most = nsdae_largest(n, w), factor = 0;
  for (int k = 1, whole = 0; k <= LARGEST && !whole; k++) {
    factor = k / most;
    whole = 1;
    for (int i = 0; i < n && whole; i++)
      whole = !(fabs(factor * w[i] - round(factor * w[i])) > 1e-6);
    if (!whole && k == LARGEST) factor = 0x1p24 / most;
  }
  for (int i = 0; i < n; i++) w[i] = round(factor * w[i]);
}

int nsdae_exact_sign(int n, const double *a, int stride, const double *u)
{
  expansion e = {.size = 0};
  int largest = NONE;
  for (int i = 0; i < n; i++) {
    double factor = a[(size_t)i * (size_t)stride];
    if (!isfinite(factor) || !isfinite(u[i])) return NSDAE_SIGN_UNKNOWN;
    int power = power_of(factor, u[i]);
    if (power > largest) largest = power;
  }
  for (int i = 0; i < n; i++) {
    double factor = a[(size_t)i * (size_t)stride];
    int power = power_of(factor, u[i]), own = power == NONE ? 0 : ilogb(factor);
    if (power == NONE) continue;
    if (power < largest - SPAN) return NSDAE_SIGN_UNKNOWN;
    double one = ldexp(factor, -own), other = ldexp(u[i], own - largest), product = one * other;
    add_exactly(&e, fma(one, other, -product));
    add_exactly(&e, product);
  }
  if (e.size == 0) return 0;
  return e.part[e.size - 1] > 0 ? 1 : -1;
}
