#include "jam.h"

#include <math.h>

#include "dense.h"
#include "errors.h"
#include "system_impl.h"

static const double margins[] = {1e-10, 1e-3};

static const char without_bound[] = "a contact force that grows without bound";

static int tell(const nsdae_contacts *c, int contact, double t, const char *what,
                double coefficient)
{
  char called[NSDAE_CALLED_SIZE];
  t = nsdae_system_time(c->system, t);
  nsdae_error_set(c->error, NSDAE_E_PAINLEVE, "nsdae_event", "mu",
                  "%s has %s at t = %.17g (Painleve's paradox: its friction feeds its "
                  "normal force, coefficient %.3g): take less friction, or method = implicit, "
                  "which resolves it by an impulse",
                  nsdae_system_called(c->system, NSDAE_NAME_CONTACT, contact, called), what, t,
                  coefficient);
  c->error->index = contact;
  c->error->time = t;
  return NSDAE_E_PAINLEVE;
}

/* Of the solved complementarity problem: what a unit of the force in that row gives of y there,
 * with all else that presses held; 0 where that is singular. It works in what the solver worked in.
 */
static double yield_of(const nsdae_contacts *c, int row)
{
  const nsdae_contact_lcp *lcp = &c->lcp;
  int n = c->rows, count = 0, *pressed = lcp->iwork, *pivot = pressed + n;
  double *A = lcp->work, *unit = A + (size_t)n * (size_t)n;
  if (lcp->liwork < 2 * n || lcp->lwork < n * (n + 1)) return INFINITY; /* no reason to doubt it */
  for (int i = 0; i < n; i++)
    if (i == row || lcp->x[i] > lcp->y[i]) pressed[count++] = i;
  for (int j = 0; j < count; j++) {
    unit[j] = pressed[j] == row;
    for (int i = 0; i < count; i++)
      A[(size_t)j * (size_t)count + (size_t)i] =
          lcp->A[(size_t)pressed[j] * (size_t)n + (size_t)pressed[i]];
  }
  if (nsdae_la_lu(count, A, count, pivot) != 0) return 0;
  nsdae_la_lu_solve(count, A, count, pivot, unit);
  for (int i = 0; i < count; i++)
    if (pressed[i] == row && unit[i] != 0) return 1 / unit[i];
  return INFINITY;
}

int nsdae_jam_judge(const nsdae_contacts *c, int status, int by_rows, nsdae_jam_margin margin,
                    double t)
{
  int unsolved = status == NSDAE_E_LCP || status == NSDAE_E_INFEASIBLE;
  for (int a = 0; a < c->active_count; a++) {
    int row = c->first_row[a];
    double coefficient = c->lcp.A[(size_t)row * (size_t)c->rows + (size_t)row];
    double least =
        margins[margin] * c->delassus.G[(size_t)c->first_column[a] * (size_t)(c->columns + 1)];
    if (c->law[c->active[a]].kind != NSDAE_SLIDING || (coefficient > least && !unsolved)) continue;
    if (status == NSDAE_OK && by_rows && yield_of(c, row) > least) continue;
    return tell(c, c->active[a], t,
                margin == NSDAE_JAM_NEAR ? without_bound
                : unsolved               ? "no contact force that solves the equations"
                                         : "two solutions",
                coefficient);
  }
  return status;
}

int nsdae_jam_unbounded(const nsdae_contacts *c, int contact, double t, double coefficient)
{
  return tell(c, contact, t, without_bound, coefficient);
}
