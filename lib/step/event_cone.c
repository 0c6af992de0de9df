/* Accelerations under friction in two directions with the cone itself, from the solution with the
 * polygon around it: projected block Gauss-Seidel (Jean, "The non-smooth contact dynamics method",
 * 1999). With xi = G F + W^T a_free + omega, in turn for every contact
 *
 *   F_N := max(0, F_N - xi_N / G_NN)
 *   F_T := the point of the disk |F_T| <= mu F_N closest to F_T - xi_T / rho,   rho >= |G_TT|
 *
 * whose fixed points are the solutions: 0 <= F_N _|_ xi_N >= 0, and F_T = -mu F_N xi_T / |xi_T|
 * where xi_T is not zero. A contact that slides already has F_T = -mu F_N d, and moves along
 * W_N - mu W_T d. */
#include <math.h>
#include <string.h>

#include "event_instant.h"
#include "vector.h"

/* F is in e->rows.force, xi in e->rows.weight. */
enum { SWEEPS = 20000 };

/* Below it, of the largest force, a change is none. */
static const double CONVERGED = 1e-14;

/* x_l += change, with what it does to xi. */
static void change_force(nsdae_event_method *e, int l, double change)
{
  const nsdae_contacts *c = &e->modes;
  const double *G = c->delassus.G + (size_t)l * (size_t)c->columns;
  e->rows.force[l] += change;
  for (int k = 0; k < c->columns; k++) e->rows.weight[k] += G[k] * change;
}

/* The normal force; of what slides already with its friction. Returns the change, or NaN where the
 * coefficient is not above zero. */
static double relax_normal(nsdae_event_method *e, int a)
{
  const nsdae_contacts *c = &e->modes;
  int column = c->first_column[a], i = c->active[a], slides = c->law[i].kind == NSDAE_SLIDING;
  double mu = slides ? e->stepper->system->contact[i].mu : 0, *force = e->rows.force;
  const double *d = e->direction + 2 * i, *G = c->delassus.G + (size_t)column * (size_t)c->columns;
  double coefficient = G[column];
  for (int l = 0; slides && l < 2; l++) coefficient -= mu * d[l] * G[column + 1 + l];
  if (!(coefficient > 0)) return coefficient == 0 && !slides ? 0 : NAN;
  double change = fmax(0, force[column] - e->rows.weight[column] / coefficient) - force[column];
  if (change == 0) return 0;
  change_force(e, column, change);
  for (int l = 0; slides && l < 2; l++) change_force(e, column + 1 + l, -mu * d[l] * change);
  return fabs(change);
}

static double relax_friction(nsdae_event_method *e, int a)
{
  const nsdae_contacts *c = &e->modes;
  int column = c->first_column[a], n = c->columns;
  double mu = e->stepper->system->contact[c->active[a]].mu, *force = e->rows.force, next[2],
         most = 0;
  double rho = c->delassus.G[(size_t)(column + 1) * (size_t)(n + 1)] +
               c->delassus.G[(size_t)(column + 2) * (size_t)(n + 1)];
  if (!(rho > 0)) return 0;
  for (int l = 0; l < 2; l++)
    next[l] = force[column + 1 + l] - e->rows.weight[column + 1 + l] / rho;
  double size = hypot(next[0], next[1]), radius = mu * force[column];
  for (int l = 0; l < 2; l++) {
    double change = (size > radius ? next[l] * (radius / size) : next[l]) - force[column + 1 + l];
    change_force(e, column + 1 + l, change);
    most = fmax(most, fabs(change));
  }
  return most;
}

/* 1 where a sweep changes nothing any more. */
static int relax(nsdae_event_method *e)
{
  const nsdae_contacts *c = &e->modes;
  for (int sweep = 0; sweep < SWEEPS; sweep++) {
    double most = 0, size = 0;
    for (int a = 0; a < c->active_count; a++) {
      double change = relax_normal(e, a);
      if (isnan(change)) return 0;
      most = fmax(most, change);
      if (c->law[c->active[a]].kind == NSDAE_POLYGON) most = fmax(most, relax_friction(e, a));
    }
    for (int l = 0; l < c->columns; l++) size = fmax(size, fabs(e->rows.force[l]));
    if (most <= CONVERGED * size) return 1;
  }
  return 0;
}

/* Forces, and what they make of a, lambda and the contacts' accelerations. */
static void take_over(nsdae_event_method *e)
{
  nsdae_contacts *c = &e->modes;
  const nsdae_dims *d = &e->stepper->system->dims;
  double *change = e->rows.solved;
  for (int l = 0; l < c->columns; l++) change[l] = e->rows.force[l] - c->delassus.impulse[l];
  nsdae_add_product(d->nv, c->columns, c->delassus.U, change, e->a);
  nsdae_add_product(d->m, c->columns, c->delassus.D, change, e->lambda);
  memcpy(c->delassus.impulse, e->rows.force, (size_t)c->columns * sizeof *c->delassus.impulse);
  for (int a = 0; a < c->active_count; a++) {
    int column = c->first_column[a], i = c->active[a];
    c->results->normal[i] = c->delassus.impulse[column];
    c->results->after[i] = e->rows.weight[column];
    for (int l = 0; l < c->law[i].columns - 1; l++) {
      c->results->tangential[2 * i + l] = c->delassus.impulse[column + 1 + l];
      c->results->after_t[2 * i + l] = e->rows.weight[column + 1 + l];
    }
  }
}

int nsdae_event_solve_cones(nsdae_event_method *e)
{
  const nsdae_contacts *c = &e->modes;
  if (c->slide_count > 0 || e->stepper->system->dims.nt != 2) return 0;
  memcpy(e->rows.force, c->delassus.impulse, (size_t)c->columns * sizeof *c->delassus.impulse);
  memcpy(e->rows.weight, c->delassus.offset, (size_t)c->columns * sizeof *c->delassus.offset);
  nsdae_add_product(c->columns, c->columns, c->delassus.G, e->rows.force, e->rows.weight);
  if (!relax(e)) return 0;
  take_over(e);
  return 1;
}
