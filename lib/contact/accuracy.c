#include "accuracy.h"

#include <limits.h>
#include <math.h>

#include "friction_solver.h"

/* contact_tol = 0. Of 12000 steps of 52 falling heaps of 2 to 12 boxes, spheres and capsules, by
 * the contacts of the largest island: mean time to 1e-10 in parts of that to 1e-4, mean
 * multiplications by J to 1e-4 and to 1e-10, the longest step to 1e-10 [ms].
 *
 *   contacts     1    2-3    4-7   8-11  12-15  16-23  24-31  32-47
 *   time      1.06   1.07   1.20   1.24    2.3    5.5     60     88
 *   to 1e-4     52     76     96     91    152    147     96     88
 *   to 1e-10    49     82    156    135    371    987   6507   6917
 *   longest    0.3    1.7     27     32    198    921    665    796
 *
 * Up to 11 contacts Newton's method from the last impulses mostly reaches 1e-10 at once, and a
 * start without impulses does within 2700 multiplications. Where 125 boxes fall on each other, of
 * 4259 such islands 54 take more than 3000, as much as all others together, and some never reach
 * 1e-10: these are solved as larger islands are. */
static const struct {
  int contacts;
  double tol, most;
} sizes[] = {{11, 1e-10, 3e3}, {INT_MAX, 1e-4, 0}};
enum { SIZES = sizeof sizes / sizeof *sizes };

/* contact_work = 0, by the tolerance from which on it holds. A sweep of Gauss-Seidel takes two
 * multiplications. A median step of heaps and walls takes 10 to 100 sweeps to 1e-4; a tenth of 1e4
 * (NSDAE_SHARE_TO_TOL) are 500. To 1e-10 a tenth of 1e6 is enough for all but 1 in 100 of the
 * islands above, and for all of up to 700 contacts of a heap of 384 spheres that falls. */
static const struct {
  double tol, work;
} works[] = {{1e-5, 1e4}, {0, 1e6}};

/* An island below FEW contacts may take as long as one of FEW: then all solvers have their turn. */
enum { FEW = 100 };

double nsdae_accuracy_tol(const nsdae_accuracy *a)
{
  return a->tol > 0 ? a->tol : sizes[0].tol;
}

double nsdae_accuracy_budget(const nsdae_accuracy *a, double tol, int contacts)
{
  const double times = contacts < FEW ? FEW / fmax(1, contacts) : 1;
  int i = 0;
  if (!(a->give > 0)) return 0;
  if (a->work > 0) return times * a->work;
  while (tol < works[i].tol) i++;
  return fmin(times * works[i].work, nsdae_fc_own_budget(contacts) / NSDAE_SHARE_TO_TOL);
}

/* A tolerance below 1e-4 makes no step fail that goes on with 1e-4; only contact_give = 1 does. */
double nsdae_accuracy_accept(const nsdae_accuracy *a, double tol)
{
  return a->give > 1 ? a->give * fmax(tol, sizes[SIZES - 1].tol) : a->give * tol;
}

nsdae_aim nsdae_accuracy_aim(const nsdae_accuracy *a, int contacts, double after)
{
  if (a->tol > 0 && after > 0) return (nsdae_aim){0, 0};
  double tol = a->tol, budget = 0;
  for (int i = 0; i < SIZES && tol == 0; i++)
    if (contacts <= sizes[i].contacts && sizes[i].tol > after)
      tol = sizes[i].tol, budget = sizes[i].most;
  if (budget == 0) budget = NSDAE_SHARE_TO_TOL * nsdae_accuracy_budget(a, tol, contacts);
  return (nsdae_aim){tol, budget};
}
