/* The problem as the caller gives it: ranges first, so that nothing after it can overflow. */
#include "problem.h"

#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>

#include "vector.h"

int nsdae_fc_refuse(nsdae_error *error, int status, const char *argument, int index,
                    const char *text)
{
  if (!error) return status;
  *error = (nsdae_error){.status = status, .index = index, .time = NAN};
  snprintf(error->argument, sizeof error->argument, "%s", argument);
  snprintf(error->where, sizeof error->where, "nsdae_friction_check");
  snprintf(error->text, sizeof error->text, "%s", text);
  return status;
}

static int refuse_int(nsdae_error *error, const char *argument, int index, int value,
                      const char *bound)
{
  char text[200];
  if (index < 0)
    snprintf(text, sizeof text, "%s = %d: must be %s", argument, value, bound);
  else
    snprintf(text, sizeof text, "%s[%d] = %d: must be %s", argument, index, value, bound);
  return nsdae_fc_refuse(error, NSDAE_E_ARGUMENT, argument, index, text);
}

static int missing(nsdae_error *error, const char *argument)
{
  char text[200];
  snprintf(text, sizeof text, "%s is NULL and must not be here", argument);
  return nsdae_fc_refuse(error, NSDAE_E_ARGUMENT, argument, -1, text);
}

/* ---- sizes and pattern */

/* NSDAE_OK if entries first to n - 1 are finite and not below least. */
static int check_values(nsdae_error *error, const char *argument, size_t first, size_t n,
                        const double *a, double least)
{
  char text[200];
  if (least < 0 && nsdae_all_finite(n - first, a + first)) return NSDAE_OK;
  for (size_t i = first; i < n; i++) {
    if (fabs(a[i]) <= DBL_MAX && a[i] >= least) continue;
    int status = fabs(a[i]) <= DBL_MAX ? NSDAE_E_ARGUMENT : NSDAE_E_NONFINITE;
    snprintf(text, sizeof text, "%s[%zu] = %g: must be %s", argument, i, a[i],
             status == NSDAE_E_ARGUMENT ? ">= 0" : "finite");
    return nsdae_fc_refuse(error, status, argument, i <= INT_MAX ? (int)i : -1, text);
  }
  return NSDAE_OK;
}

/* Counts, and arrays, that fit what indexes them: 3 contacts + bilateral + 3 and all sums in int.
 */
static int check_counts(const nsdae_friction_problem *p, nsdae_error *error)
{
  if (p->form != NSDAE_FRICTION_GLOBAL && p->form != NSDAE_FRICTION_LOCAL)
    return refuse_int(error, "form", -1, p->form, "NSDAE_FRICTION_GLOBAL or NSDAE_FRICTION_LOCAL");
  if (p->contacts < 0 || p->contacts > INT_MAX / 8)
    return refuse_int(error, "contacts", -1, p->contacts, "in [0, 268435455]");
  if (p->bilateral < 0 || p->bilateral > INT_MAX / 8)
    return refuse_int(error, "bilateral", -1, p->bilateral, "in [0, 268435455]");
  if (p->blocks < 0 || (p->form == NSDAE_FRICTION_LOCAL && p->blocks > 0))
    return refuse_int(error, "blocks", -1, p->blocks, p->blocks < 0 ? ">= 0" : "0 in local form");
  int items = p->contacts + p->bilateral;
  if (p->contacts > 0 && !p->mu) return missing(error, "mu");
  if (items > 0 && !p->w) return missing(error, "w");
  if (items > 0 && !p->first) return missing(error, "first");
  if (p->blocks > 0 && !p->size) return missing(error, "size");
  if (p->blocks > 0 && !p->M) return missing(error, "M");
  if (p->blocks > 0 && !p->f) return missing(error, "f");
  if (items > 0 && p->first[items] > 0 && !p->block) return missing(error, "block");
  if (items > 0 && p->first[items] > 0 && !p->value) return missing(error, "value");
  int most = p->form == NSDAE_FRICTION_GLOBAL ? p->blocks : items;
  if (items > 0 && p->first[0] != 0) return refuse_int(error, "first", 0, p->first[0], "0");
  for (int i = 0; i < items; i++)
    if (p->first[i + 1] < p->first[i] || p->first[i + 1] - p->first[i] > most)
      return refuse_int(error, "first", i + 1, p->first[i + 1],
                        "not below the one before, and above it by no more than there are blocks");
  return NSDAE_OK;
}

/* Sizes of the blocks; those of M must add up to less than a size_t and those of v to an int. Each
 * item touches blocks that exist, each once: lists are short, no marks are kept. */
static int check_sizes(const nsdae_friction_problem *p, nsdae_error *error)
{
  int nv = 0;
  for (int i = 0; i < p->contacts && p->rows; i++)
    if (p->rows[i] < 1 || p->rows[i] > 3)
      return refuse_int(error, "rows", i, p->rows[i], "1, 2 or 3 (no rolling friction)");
  for (int b = 0; b < p->blocks; b++) {
    if (p->size[b] < 1) return refuse_int(error, "size", b, p->size[b], ">= 1");
    if (p->size[b] > INT_MAX / 2 - nv)
      return refuse_int(error, "size", b, p->size[b], "less: the sizes overflow");
    nv += p->size[b];
  }
  size_t of_mass = 0;
  for (int b = 0; b < p->blocks; b++) {
    size_t n = (size_t)p->size[b];
    if (n > SIZE_MAX / 32 / n || n * n > SIZE_MAX / 32 - of_mass)
      return refuse_int(error, "size", b, p->size[b], "less: M overflows");
    of_mass += n * n;
  }
  int items = p->contacts + p->bilateral;
  int most = p->form == NSDAE_FRICTION_GLOBAL ? p->blocks : items;
  for (int i = 0; i < items; i++)
    for (int e = p->first[i]; e < p->first[i + 1]; e++) {
      if (p->block[e] < 0 || p->block[e] >= most)
        return refuse_int(error, "block", e, p->block[e], "a block that exists");
      for (int k = p->first[i]; k < e; k++)
        if (p->block[k] == p->block[e])
          return refuse_int(error, "block", e, p->block[e], "named once in an item");
    }
  return NSDAE_OK;
}

/* ---- data */

/* Entries of the part of an item in a block. */
static size_t part(const nsdae_friction_problem *p, int item, int block)
{
  int other = p->form == NSDAE_FRICTION_GLOBAL ? p->size[block] : nsdae_fc_rows(p, block);
  return (size_t)other * (size_t)nsdae_fc_rows(p, item);
}

/* What the problem in view->p has. */
static void count(nsdae_fc_view *view)
{
  const nsdae_friction_problem *p = view->p;
  view->items = p->contacts + p->bilateral;
  view->entries = view->items > 0 ? p->first[view->items] : 0;
  view->m = view->nv = 0;
  view->mass = view->values = 0;
  for (int b = 0; b < p->blocks; b++) {
    view->nv += p->size[b];
    view->mass += (size_t)p->size[b] * (size_t)p->size[b];
  }
  for (int i = 0; i < view->items; i++) {
    view->m += nsdae_fc_rows(p, i);
    for (int e = p->first[i]; e < p->first[i + 1]; e++) view->values += part(p, i, p->block[e]);
  }
}

static int check_data(const nsdae_friction_problem *p, nsdae_error *error)
{
  nsdae_fc_view view = {.p = p};
  count(&view);
  size_t nv = (size_t)view.nv, m = (size_t)view.m;
  for (int i = 0; i < p->contacts; i++) {
    if (nsdae_fc_rows(p, i) == 1) continue;
    int status = check_values(error, "mu", (size_t)i, (size_t)i + 1, p->mu, 0);
    if (status != NSDAE_OK) return status;
  }
  int status = check_values(error, "w", 0, m, p->w, -INFINITY);
  if (status == NSDAE_OK && p->compliance)
    status = check_values(error, "compliance", 0, m, p->compliance, 0);
  if (status == NSDAE_OK) status = check_values(error, "f", 0, nv, p->f, -INFINITY);
  if (status == NSDAE_OK) status = check_values(error, "M", 0, view.mass, p->M, -INFINITY);
  if (status != NSDAE_OK || m == 0) return status;
  return check_values(error, "value", 0, view.values, p->value, -INFINITY);
}

int nsdae_fc_problem_check(const nsdae_friction_problem *p, nsdae_error *error)
{
  if (error) *error = (nsdae_error){.index = -1, .time = NAN};
  if (!p) return missing(error, "problem");
  int status = check_counts(p, error);
  if (status == NSDAE_OK) status = check_sizes(p, error);
  return status == NSDAE_OK ? check_data(p, error) : status;
}

/* ---- view by parts */

void nsdae_fc_view_layout(nsdae_fc_view *view, nsdae_arena *arena)
{
  const nsdae_friction_problem *p = view->p;
  count(view);
  view->row = NSDAE_ARENA_INTS(arena, view->items + 1);
  view->offset = NSDAE_ARENA_INTS(arena, p->blocks + 1);
  view->mass_at = nsdae_arena_take(arena, (long)p->blocks + 1, sizeof(size_t));
  view->at = nsdae_arena_take(arena, (long)view->entries + 1, sizeof(size_t));
}

void nsdae_fc_view_fill(nsdae_fc_view *view)
{
  const nsdae_friction_problem *p = view->p;
  view->row[0] = view->offset[0] = 0;
  view->mass_at[0] = view->at[0] = 0;
  for (int i = 0; i < view->items; i++) view->row[i + 1] = view->row[i] + nsdae_fc_rows(p, i);
  for (int b = 0; b < p->blocks; b++) {
    view->offset[b + 1] = view->offset[b] + p->size[b];
    view->mass_at[b + 1] = view->mass_at[b] + (size_t)p->size[b] * (size_t)p->size[b];
  }
  for (int i = 0; i < view->items; i++)
    for (int e = p->first[i]; e < p->first[i + 1]; e++)
      view->at[e + 1] = view->at[e] + part(p, i, p->block[e]);
}
