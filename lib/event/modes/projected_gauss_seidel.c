#include "acceleration.h"

#include <math.h>
#include <string.h>

#include "system_impl.h"

enum { FEW = 30, SWEEPS = 20000, LOOK = 500 };

/* Below it, of the largest force, a change is none. */
static const double CONVERGED = 1e-14;

/* Of what a force alone takes to stop its contact: more is bodies pressed against each other, of
 * which the rounding is felt. */
static const double PRESSED = 1e6;

typedef struct relaxation {
  const nsdae_contacts *c;
  const double *direction;
  double *force, *xi;
} relaxation;

/* ---- one sweep of projected Gauss-Seidel */

/* F_l += change, with what it does to xi. */
static void change_force(const relaxation *r, int l, double change)
{
  r->force[l] += change;
  for (int k = 0; k < r->c->columns; k++)
    r->xi[k] += r->c->delassus.G[(size_t)l * (size_t)r->c->columns + (size_t)k] * change;
}

/* The normal force; of what slides already with its friction. Returns the change, or NaN where the
 * coefficient is not above zero. */
static double relax_normal(const relaxation *r, int a)
{
  const nsdae_contacts *c = r->c;
  int column = c->first_column[a], i = c->active[a], slides = c->law[a].kind == NSDAE_SLIDING;
  double mu = slides ? c->system->contact[i].mu : 0;
  const double *d = r->direction + 2 * i, *G = c->delassus.G + (size_t)column * (size_t)c->columns;
  double coefficient = G[column];
  for (int l = 0; slides && l < 2; l++) coefficient -= mu * d[l] * G[column + 1 + l];
  if (!(coefficient > 0)) return coefficient == 0 && !slides ? 0 : NAN;
  double change = fmax(0, r->force[column] - r->xi[column] / coefficient) - r->force[column];
  if (change == 0) return 0;
  change_force(r, column, change);
  for (int l = 0; slides && l < 2; l++) change_force(r, column + 1 + l, -mu * d[l] * change);
  return fabs(change);
}

static double relax_friction(const relaxation *r, int a)
{
  const nsdae_contacts *c = r->c;
  int column = c->first_column[a], n = c->columns;
  double *F_T = r->force + column + 1, next[2], most = 0;
  double rho = c->delassus.G[(size_t)(column + 1) * (size_t)(n + 1)] +
               c->delassus.G[(size_t)(column + 2) * (size_t)(n + 1)];
  if (!(rho > 0)) return 0;
  for (int l = 0; l < 2; l++) next[l] = F_T[l] - r->xi[column + 1 + l] / rho;
  double size = hypot(next[0], next[1]);
  double radius = c->system->contact[c->active[a]].mu * r->force[column];
  for (int l = 0; l < 2; l++) {
    double change = (size > radius ? next[l] * (radius / size) : next[l]) - F_T[l];
    change_force(r, column + 1 + l, change);
    most = fmax(most, fabs(change));
  }
  return most;
}

/* Whether sweeps that converge linearly come to the end within twice those that are left: the
 * changes of one and of that LOOK sweeps earlier, over the largest force. */
static int comes_to_an_end(int left, double change, double earlier)
{
  double wanted = log(change / CONVERGED), gained = log(earlier / change);
  return gained > 0 && wanted / gained * (double)LOOK <= 2 * left;
}

/* 1 where, of these, a sweep changes nothing any more; < 0 where there is no fixed point. */
static int relax(const relaxation *r, int sweeps)
{
  const nsdae_contacts *c = r->c;
  double earlier = INFINITY;
  for (int sweep = 0; sweep < sweeps; sweep++) {
    double most = 0;
    for (int a = 0; a < c->active_count; a++) {
      double change = relax_normal(r, a);
      if (isnan(change)) return -1;
      most = fmax(most, change);
      if (c->law[a].kind == NSDAE_POLYGON) most = fmax(most, relax_friction(r, a));
    }
    double size = nsdae_largest(c->columns, r->force);
    if (most <= CONVERGED * size) return 1;
    if (sweep % LOOK != LOOK - 1) continue;
    if (!comes_to_an_end(sweeps - sweep, most / size, earlier)) return 0;
    earlier = most / size;
  }
  return 0;
}

/* ---- residual */

/* xi of the forces. */
static void read_xi(const relaxation *r)
{
  const nsdae_contacts *c = r->c;
  memcpy(r->xi, c->delassus.offset, (size_t)c->columns * sizeof *r->xi);
  nsdae_add_product(c->columns, c->columns, c->delassus.G, r->force, r->xi);
}

/* How far the forces are from solving the problem, of the largest: by the map whose fixed points
 * the solutions are, at xi computed afresh. What has only stopped is no solution. */
static double residual(const relaxation *r)
{
  const nsdae_contacts *c = r->c;
  double most = 0, size = nsdae_largest(c->columns, r->force);
  read_xi(r);
  for (int a = 0; a < c->active_count; a++) {
    double change = relax_normal(r, a);
    if (c->law[a].kind == NSDAE_POLYGON) change = fmax(change, relax_friction(r, a));
    if (!(change <= most)) most = change; /* NaN, too */
  }
  return size > 0 ? most / size : most;
}

/* ---- all sweeps */

/* Where bodies touch in more points than they have freedoms sweeps go on for thousands of times:
 * what a few do not settle is the friction chain's, if it can take it. */
static int settle(nsdae_contacts *c, const relaxation *r)
{
  int settled = relax(r, FEW);
  if (settled == 0 && nsdae_cones_improve(c, r->force)) {
    read_xi(r);
    return 1;
  }
  return (settled != 0 ? settled : relax(r, SWEEPS)) > 0;
}

/* The same with its certificate, which is the problem's from then on. */
static int is_settled(nsdae_contacts *c, const relaxation *r)
{
  if (!settle(c, r)) return 0;
  double off = residual(r);
  if (!(off <= c->lcp.options.tol)) return 0;
  c->lcp.info.residual = off;
  return 1;
}

/* The forces, and what their change makes of v, lambda and the contacts' velocities. */
static void take_over(nsdae_contacts *c, const double *force, const double *xi, double *v,
                      double *lambda)
{
  for (int l = 0; l < c->columns; l++) {
    double change = force[l] - c->delassus.impulse[l];
    nsdae_add_product(c->system->dims.nv, 1, c->delassus.U + (size_t)l * (size_t)c->system->dims.nv,
                      &change, v);
    nsdae_add_product(c->system->dims.m, 1, c->delassus.D + (size_t)l * (size_t)c->system->dims.m,
                      &change, lambda);
    c->delassus.impulse[l] = force[l];
  }
  for (int a = 0; a < c->active_count; a++) {
    int column = c->first_column[a], i = c->active[a];
    const nsdae_coefficients *e = &c->system->contact[i];
    c->results->normal[i] = force[column];
    c->results->mode[i] = NSDAE_MODE_STICK; /* no longer what the polygons said */
    c->results->after[i] = xi[column] - e->e_n * c->results->before[i];
    for (int l = 0; l < c->law[a].columns - 1; l++) {
      c->results->tangential[2 * i + l] = force[column + 1 + l];
      c->results->after_t[2 * i + l] =
          xi[column + 1 + l] - e->e_t * c->results->before_t[2 * i + l];
    }
  }
}

/* ---- interface */

int nsdae_projected_gauss_seidel(nsdae_contacts *c, const double *direction, double *force,
                                 double *xi, double *v, double *lambda)
{
  const relaxation r = {c, direction, force, xi};
  if (c->slides.count > 0 || c->system->dims.nt != 2) return 0;
  memcpy(force, c->delassus.impulse, (size_t)c->columns * sizeof *force);
  read_xi(&r);
  if (!is_settled(c, &r)) return 0;
  take_over(c, force, xi, v, lambda);
  return 1;
}

int nsdae_projected_gauss_seidel_anew(nsdae_contacts *c, const double *direction, double *force,
                                      double *xi, double *v, double *lambda)
{
  if (c->slides.count > 0 || c->system->dims.nt != 2) return 0;
  memset(c->delassus.impulse, 0, (size_t)c->columns * sizeof *c->delassus.impulse);
  return nsdae_projected_gauss_seidel(c, direction, force, xi, v, lambda);
}

int nsdae_contacts_pressed(const nsdae_contacts *c)
{
  double most = PRESSED * nsdae_largest(c->columns, c->delassus.offset);
  for (int l = 0; l < c->columns; l++)
    if (fabs(c->delassus.impulse[l]) * c->delassus.G[(size_t)l * (size_t)(c->columns + 1)] > most)
      return 1;
  return 0;
}
