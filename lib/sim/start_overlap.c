/* Overlap of a start, beyond its tolerance (initial_conditions.c).
 *
 * projection = slop moves bodies out in the first steps. Beyond a tenth of the smaller body this is
 * no correction but another start, and an error. Where widths are unknown a tenth of the numbers is
 * taken, with the tolerance's own measure: 0.1 (1 + |W_N,i|_1 max |q|). */
#include <math.h>

#include "errors.h"
#include "listed.h"
#include "sim_impl.h"
#include "system_impl.h"

/* Share of a body that projection = slop may move a start by: tol above is of numbers, and wrong
 * units, signs or places are off by the size of a body and more. */
static const double moved_share = 0.1;

/* Width of the smaller body of contact j; 0: unknown. */
static double width_of(const nsdae_terms *T, int j)
{
  const nsdae_system *s = T->system;
  const nsdae_rows *W = &T->by.normal;
  const double *size = s->size[NSDAE_NAME_CONTACT];
  double least = INFINITY;
  if (!size) return 0;
  if (!s->tracked && nsdae_terms_most(s) != NSDAE_ANY_NUMBER) return size[j];
  for (int p = W->first[j]; p < W->first[j + 1]; p++)
    if (size[W->block[p]] > 0) least = fmin(least, size[W->block[p]]);
  return isfinite(least) ? least : 0;
}

/* A contact of the start, its depth and the bound that it exceeds. */
typedef struct overlap {
  int contact; /* -1: none */
  double depth, bound;
} overlap;

static void compare_overlap(overlap *deepest, int contact, double depth, double bound)
{
  if (depth > bound && depth > deepest->depth) *deepest = (overlap){contact, depth, bound};
}

static int report_overlap(nsdae_terms *T, const overlap *o, int status, const char *what)
{
  char called[NSDAE_CALLED_SIZE];
  nsdae_error_set(
      T->error, status, "nsdae_sim_init", "q0", "%s overlaps by %.6g at the start%s%.3g%s",
      nsdae_terms_called(T, NSDAE_NAME_CONTACT, o->contact, called), o->depth,
      status < 0 ? ": it must be at most " : ", above the bound of start_tol (", o->bound, what);
  return nsdae_error_at(T->error, status,
                        nsdae_system_index(T->system, NSDAE_NAME_CONTACT, o->contact),
                        nsdae_terms_time(T));
}

/* event needs a start without overlap: a contact that is closed has the gap 0 there. */
int nsdae_initial_overlap(nsdae_terms *T, const nsdae_sim_options *options)
{
  const int method = options->method, projection = nsdae_sim_projection(options);
  const int slop = projection == NSDAE_PROJECTION_SLOP;
  double q = nsdae_largest(T->system->dims.nq, T->q), tol = options->start_tol;
  overlap any = {.contact = -1}, large = any;
  nsdae_terms_select_all(T);
  for (int j = 0; j < T->by.normal.count && method != NSDAE_METHOD_PENALTY; j++) {
    double scale = 1 + q * nsdae_rows_sum(&T->system->blocks, &T->by.normal, j);
    double width = slop ? width_of(T, j) : 0;
    compare_overlap(&any, j, -T->gap[j], tol * scale);
    if (slop)
      compare_overlap(&large, j, -T->gap[j],
                      fmax(tol * scale, moved_share * (width > 0 ? width : scale)));
  }
  if (any.contact < 0) return NSDAE_OK;
  if (method == NSDAE_METHOD_EVENT)
    return report_overlap(T, &any, NSDAE_E_ARGUMENT,
                          " (see start_tol); nsdae_sim_project corrects it");
  if (large.contact >= 0)
    return report_overlap(T, &large, NSDAE_E_ARGUMENT,
                          ", a tenth of its size, with projection = slop (see start_tol); "
                          "nsdae_sim_project corrects it");
  return report_overlap(T, &any, NSDAE_WARN_PENETRATION,
                        slop || projection == NSDAE_PROJECTION_CONTACTS
                            ? "): the first step in which it is closed moves it out; "
                              "nsdae_sim_project corrects it before"
                            : "): the method keeps this overlap; nsdae_sim_project corrects it");
}
