#include "dense_residual.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "slides.h"
#include "vector.h"

/* W_j^T M^-1 W_j: without constraints the Delassus matrix has it. */
static double diagonal(const nsdae_dense_island *l, int j)
{
  const nsdae_delassus *d = &l->contacts.delassus;
  int n = l->kkt.n;
  const double *W = d->W + (size_t)j * (size_t)n;
  if (l->kkt.m == 0) return d->G[(size_t)j * (size_t)(l->contacts.columns + 1)];
  memcpy(l->column, W, (size_t)n * sizeof *W);
  nsdae_kkt_solve_mass(&l->kkt, l->column);
  return nsdae_dot(n, W, l->column);
}

/* With constraints: the velocity along column j without any impulse, u being that of v. */
static void fit_speed(const nsdae_dense_island *l, int j, double u,
                      nsdae_natural_residual *residual)
{
  const double *W = l->contacts.delassus.W + (size_t)j * (size_t)l->kkt.n;
  if (l->kkt.m > 0) nsdae_natural_residual_speed(residual, u + nsdae_dot(l->kkt.n, W, l->free));
}

/* |W|^T |x + y| of a contact, the largest of its columns. */
static double size_along(const nsdae_dense_island *l, int column, int columns, const double *x,
                         const double *y)
{
  const double *W = l->contacts.delassus.W + (size_t)column * (size_t)l->kkt.n;
  double most = 0;
  for (int c = 0; c < columns; c++) {
    double sum = 0;
    for (int j = 0; j < l->kkt.n; j++) sum += fabs(*W++ * (x[j] + (y ? y[j] : 0)));
    most = fmax(most, sum);
  }
  return most;
}

/* v is as good as contacts.c has it, to 32 roundings of its terms, and has no digits below DBL_MIN:
 * of velocities along columns of W. */
static double rounding_of(const nsdae_dense_island *l, int column, int columns)
{
  return 32 * DBL_EPSILON * size_along(l, column, columns, l->at.size, NULL) + DBL_MIN;
}

/* What the rounding of impulses forgives, where it is more than tol of how fast the bodies would be
 * without any: less is no error of their motion. */
static void hide(const nsdae_dense_island *l, int column, int columns, double left,
                 nsdae_natural_residual *residual)
{
  double forgiven = fmin(left, rounding_of(l, column, columns));
  if (forgiven > l->contacts.lcp.options.tol * size_along(l, column, columns, l->at.v, l->free))
    nsdae_natural_residual_raise(&residual->hidden, forgiven);
}

/* The residual of a law with velocities along columns of W. */
static void leave(const nsdae_dense_island *l, int column, int columns, int rounded, double left,
                  nsdae_natural_residual *residual)
{
  if (rounded) left -= rounding_of(l, column, columns);
  nsdae_natural_residual_row(residual, left < 0 ? 0 : left);
}

/* What the law of the a-th contact leaves where it has friction; d, u_N: of its normal. */
static double fit_friction(const nsdae_dense_island *l, int a, double d, double u_N,
                           nsdae_natural_residual *residual)
{
  const nsdae_contacts *c = &l->contacts;
  const nsdae_impulses *r = c->results;
  int i = c->active[a], columns = c->law[a].columns;
  const nsdae_coefficients *law = &c->part.coefficient[i];
  double x[3], u[3] = {u_N};
  for (int j = 1, t = i * (columns - 1); j < columns; j++, t++) {
    u[j] = r->after_t[t] + law->e_t * r->before_t[t];
    x[j] = r->tangential[t];
    d += diagonal(l, c->first_column[a] + j);
    fit_speed(l, c->first_column[a] + j, u[j], residual);
  }
  if (c->law[a].kind == NSDAE_POLYGON) return 0;
  d /= columns;
  x[0] = d * r->normal[i];
  for (int j = 1; j < columns; j++) x[j] *= d;
  return columns == 2 ? nsdae_natural_planar(law->mu, x, u)
                      : nsdae_fc_natural(NSDAE_FC_CONE, law->mu, x, NULL, u);
}

/* Residual of the a-th contact: impulses in units of velocity by the mean diagonal of G, against
 * the law. */
static void fit_contact(const nsdae_dense_island *l, int a, int rounded,
                        nsdae_natural_residual *residual)
{
  const nsdae_contacts *c = &l->contacts;
  const nsdae_impulses *r = c->results;
  int i = c->active[a], column = c->first_column[a], columns = c->law[a].columns;
  double u = r->after[i] + c->part.coefficient[i].e_n * r->before[i], d = diagonal(l, column);
  fit_speed(l, column, u, residual);
  double left =
      columns == 1 ? nsdae_natural_normal(d * r->normal[i], u) : fit_friction(l, a, d, u, residual);
  if (rounded) hide(l, column, columns, left, residual);
  leave(l, column, columns, rounded, left, residual);
}

/* Of a frictional joint: |d Lambda - P(d Lambda - u)|, P onto |Lambda| <= bound + mu |lambda|. Of a
 * position motor u and d have what its row has beside xi_T. */
static void fit_joint(const nsdae_dense_island *l, int i, int rounded,
                      nsdae_natural_residual *residual)
{
  const nsdae_contacts *c = &l->contacts;
  int j = c->slides.number[i], column = c->columns - c->slides.count + i;
  const nsdae_joint_row beside = nsdae_slides_beside(c, i);
  double x = c->results->frictional_joint_impulse[j] / beside.scale,
         free = beside.scale * c->results->slide_after[j] + beside.shift,
         u = free + beside.compliance * x,
         d = diagonal(l, column) + (l->kkt.m > 0 ? beside.compliance : 0);
  fit_speed(l, column, free, residual);
  double mu = c->system->frictional_joint[j].mu,
         load = mu > 0 ? mu * fabs(l->at.lambda[c->slides.constraint[i]]) : 0;
  double most = d * (load + nsdae_slides_bound(c, i));
  double left = fabs(d * x - fmax(-most, fmin(most, d * x - u)));
  leave(l, column, 1, rounded, left, residual);
}

static void fit_row(const nsdae_dense_island *l, int i, int rounded,
                    nsdae_natural_residual *residual)
{
  const nsdae_island_view *at = &l->at;
  double u = nsdae_rows_add_dot(at->blocks, at->J, i, at->v, -l->asked[i]);
  double rounding =
      rounded ? 32 * DBL_EPSILON * nsdae_rows_dot_sizes(at->blocks, at->J, i, at->size) + DBL_MIN
              : 0;
  nsdae_natural_residual_row(residual, fabs(u) <= rounding ? 0 : u);
  nsdae_natural_residual_speed(residual, u + nsdae_rows_dot(at->blocks, at->J, i, l->free));
}

nsdae_natural_residual nsdae_dense_residual(const nsdae_dense_island *l, int rounded)
{
  const nsdae_contacts *c = &l->contacts;
  nsdae_natural_residual residual = {0};
  if (l->kkt.m > 0 || rounded) {
    memcpy(l->free, l->at.r, (size_t)l->kkt.n * sizeof *l->free);
    nsdae_kkt_solve_mass(&l->kkt, l->free);
    for (int j = 0; j < l->kkt.n; j++) l->free[j] -= l->at.v[j];
  }
  if (l->kkt.m == 0) residual.speed = nsdae_largest(c->columns, c->delassus.offset);
  for (int a = 0; a < c->active_count; a++) fit_contact(l, a, rounded, &residual);
  for (int i = 0; i < c->slides.count; i++) fit_joint(l, i, rounded, &residual);
  for (int i = 0; i < l->kkt.m; i++) fit_row(l, i, rounded, &residual);
  if (nsdae_contacts_polygons(c))
    nsdae_natural_residual_row(&residual, c->lcp.info.residual * residual.speed);
  return residual;
}
