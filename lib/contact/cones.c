#include "cones.h"

#include <math.h>
#include <string.h>

#include "friction_solver.h"
#include "slides.h"
#include "vector.h"

/* Newton steps after the solution; rounds of contacts and frictional joints. */
enum { REFINE = 4, ROUNDS = 500 };

/* Multiplications by W of an attempt to improve what sweeps have found: some 200 Newton steps of a
 * small problem. Further sweeps of the caller cost less than more of these. */
static const double IMPROVE = 5000;

void nsdae_cones_layout(nsdae_cones *s, long contacts, long columns, long m, nsdae_arena *arena)
{
  long n = contacts;
  s->room = (int)n;
  s->rows = NSDAE_ARENA_INTS(arena, n);
  s->first = NSDAE_ARENA_INTS(arena, n + 1);
  s->block = NSDAE_ARENA_INTS(arena, n * n);
  s->mu = NSDAE_ARENA_DOUBLES(arena, n);
  nsdae_arena_doubles(arena, columns, (double **[]){&s->q, &s->r, &s->u, &s->guess, NULL});
  s->W = NSDAE_ARENA_DOUBLES(arena, columns * columns);
  nsdae_arena_doubles(arena, s->most > 0 ? columns : 0, (double **[]){&s->free, &s->held, NULL});
  s->lambda = NSDAE_ARENA_DOUBLES(arena, s->most > 0 ? m : 0);
}

/* The problem of this number of contacts, each of which touches all. */
static void set_pattern(nsdae_cones *s, int contacts)
{
  s->problem = (nsdae_friction_problem){.form = NSDAE_FRICTION_LOCAL,
                                        .contacts = contacts,
                                        .rows = s->rows,
                                        .mu = s->mu,
                                        .w = s->q,
                                        .first = s->first,
                                        .block = s->block,
                                        .value = s->W};
  for (int a = 0; a <= contacts; a++) s->first[a] = a * contacts;
  for (size_t e = 0; e < (size_t)contacts * (size_t)contacts; e++)
    s->block[e] = (int)(e % (size_t)contacts);
}

int nsdae_cones_open(nsdae_cones *s)
{
  size_t rows = 0;
  if (s->most == 0) return NSDAE_OK;
  if (!s->solver && nsdae_friction_create(&s->solver) < 0) return NSDAE_E_MEMORY;
  set_pattern(s, s->room);
  for (int a = 0; a < s->room; a++) rows += (size_t)(s->rows[a] = a < s->most ? 3 : 2);
  for (size_t i = 0; i < rows * rows; i++) s->W[i] = 1; /* one island of all */
  return nsdae_fc_reserve(s->solver, &s->problem);
}

void nsdae_cones_close(nsdae_cones *s)
{
  nsdae_friction_destroy(&s->solver);
}

int nsdae_cones_any(const nsdae_contacts *c)
{
  for (int a = 0; a < c->active_count; a++)
    if (c->law[a].kind == NSDAE_CONE) return 1;
  return 0;
}

/* ---- the local problem of friction */

static double delassus_at(const nsdae_contacts *c, int row, int column)
{
  return c->delassus.G[(size_t)column * (size_t)c->columns + (size_t)row];
}

/* G is symmetric up to rounding, and zero where the constraints leave a column no motion. */
static double symmetric_at(const nsdae_contacts *c, int i, int j)
{
  if (!(delassus_at(c, i, i) > 0) || !(delassus_at(c, j, j) > 0)) return 0;
  return (delassus_at(c, i, j) + delassus_at(c, j, i)) / 2;
}

/* Number of the closed contacts' columns, which are also their rows. */
static int contact_columns(const nsdae_contacts *c)
{
  return c->first_column[c->active_count];
}

/* Column of row l of item a: of a joint -1 and its own. */
static int column_of(const nsdae_contacts *c, int a, int l)
{
  if (a < c->active_count) return c->first_column[a] + l;
  return l == 0 ? -1 : contact_columns(c) + a - c->active_count;
}

/* d of joint j: G_jj, if there is any, and less if the limit then has more than the scale of the
 * problem, max |offset|. */
static double diagonal_of(const nsdae_contacts *c, int j)
{
  double d = delassus_at(c, contact_columns(c) + j, contact_columns(c) + j);
  return nsdae_slides_normal(d > 0 ? d : 1, c->slides.limit[j], c->slides.fastest);
}

/* The closed contacts, and this number of joints. */
static void set_values(nsdae_contacts *c, int joints)
{
  nsdae_cones *s = &c->cones;
  double *W = s->W;
  int items = c->active_count + joints;
  set_pattern(s, items);
  for (int a = 0; a < items; a++) {
    int joint = a - c->active_count;
    s->rows[a] = joint < 0 ? c->law[a].columns : 2;
    s->mu[a] = joint < 0 ? c->law[a].mu : 1;
  }
  for (int a = 0; a < items; a++)
    for (int b = 0; b < items; b++)
      for (int j = 0; j < s->rows[a]; j++)
        for (int i = 0; i < s->rows[b]; i++) {
          int row = column_of(c, b, i), column = column_of(c, a, j);
          double normal = a == b && row == column ? diagonal_of(c, a - c->active_count) : 0;
          *W++ = row < 0 || column < 0 ? normal : symmetric_at(c, row, column);
        }
}

/* The impulses before. */
static void recall(nsdae_contacts *c)
{
  int nt = c->system->dims.nt;
  for (int a = 0; a < c->active_count; a++) {
    double *r = c->cones.r + c->first_column[a];
    r[0] = c->results->normal[c->active[a]];
    for (int l = 1; l < c->law[a].columns; l++)
      r[l] = c->results->tangential[c->active[a] * nt + l - 1];
  }
}

/* From s->r on, of rows in all. */
static int solve_problem(nsdae_contacts *c, int rows, double tol)
{
  nsdae_cones *s = &c->cones;
  memcpy(s->q, c->delassus.offset, (size_t)contact_columns(c) * sizeof *s->q);
  memcpy(s->guess, s->r, (size_t)rows * sizeof *s->r);
  s->options.tol = tol;
  int status =
      nsdae_friction_solver_solve(s->solver, &s->problem, &s->options, s->r, s->u, &s->info);
  c->lcp.info.outcome = s->info.outcome;
  c->lcp.info.residual = s->info.residual;
  return status;
}

static int solve_contacts(nsdae_contacts *c, double tol)
{
  return solve_problem(c, contact_columns(c), tol);
}

/* ---- joints with a bound as contacts */

/* As of nsdae_cones_mode. */
static int joint_mode(const nsdae_contacts *c, int j)
{
  const nsdae_cones *s = &c->cones;
  const double *r = s->r + contact_columns(c) + 2 * j, *u = s->u + contact_columns(c) + 2 * j;
  double margin = diagonal_of(c, j) * (r[0] - fabs(r[1])),
         size = fabs(c->delassus.offset[contact_columns(c) + j]);
  return fabs(u[1]) > fmax(margin, s->options.tol * size) ? NSDAE_MODE_SLIP : NSDAE_MODE_STICK;
}

/* Where no contact has a load, those that touch without velocity begin with the joints' limits in
 * equal parts. Of them rounding would decide which are closed in the first step of Newton's method,
 * and so which of many solutions it finds: one has all load at a corner, about which the body
 * turns. Of others the velocity decides it. With such a load they may jam, where a solution moves.
 */
static void share_limits(nsdae_contacts *c)
{
  double *r = c->cones.r, none = c->lcp.options.tol * c->slides.fastest, sum = 0;
  if (nsdae_largest(contact_columns(c), r) > 0) return;
  for (int j = 0; j < c->slides.count; j++) sum += c->slides.limit[j];
  for (int a = 0; a < c->active_count; a++)
    if (fabs(c->delassus.offset[c->first_column[a]]) <= none)
      r[c->first_column[a]] = sum / c->active_count;
}

static int solve_with_joints(nsdae_contacts *c, const double *lambda)
{
  nsdae_cones *s = &c->cones;
  int columns = contact_columns(c), count = c->slides.count;
  (void)lambda;
  set_values(c, count);
  share_limits(c);
  for (int j = 0; j < count; j++) {
    double *r = s->r + columns + 2 * j, *q = s->q + columns + 2 * j;
    r[0] = c->slides.limit[j];
    r[1] =
        c->results->frictional_joint_impulse[c->slides.number[j]] / nsdae_slides_beside(c, j).scale;
    q[0] = -diagonal_of(c, j) * c->slides.limit[j];
    q[1] = c->delassus.offset[columns + j];
  }
  int status = solve_problem(c, columns + 2 * count, c->lcp.options.tol);
  for (int j = 0; j < count && status == NSDAE_OK; j++) {
    double limit = c->slides.limit[j], impulse = s->r[columns + 2 * j + 1];
    impulse = fmax(-limit, fmin(limit, impulse));
    c->delassus.impulse[columns + j] = impulse;
    c->delassus.impulse_size[columns + j] = fabs(impulse);
    c->results->frictional_joint_impulse[c->slides.number[j]] =
        impulse * nsdae_slides_beside(c, j).scale;
    c->results->frictional_joint_mode[c->slides.number[j]] = joint_mode(c, j);
  }
  return status;
}

/* ---- contacts and frictional joints in turn */

/* offset := free + G impulse, of the columns from first on. */
static void hold(nsdae_contacts *c, int first, int count, const double *impulse)
{
  size_t n = (size_t)c->columns;
  memcpy(c->delassus.offset, c->cones.free, n * sizeof *c->delassus.offset);
  nsdae_add_product(c->columns, count, c->delassus.G + (size_t)first * n, impulse,
                    c->delassus.offset);
}

/* The slides with the contacts' impulses held: then there are no other rows. */
static int solve_slides(nsdae_contacts *c, const double *lambda)
{
  nsdae_cones *s = &c->cones;
  int contacts = c->active_count, columns = contact_columns(c), m = c->part.m;
  hold(c, 0, columns, s->r);
  memcpy(s->lambda, lambda, (size_t)m * sizeof *lambda);
  nsdae_add_product(m, columns, c->delassus.D, s->r, s->lambda);
  c->active_count = 0;
  nsdae_contacts_place_slides(c, 0);
  int status = nsdae_slides_solve(c, s->lambda);
  c->active_count = contacts;
  nsdae_contacts_place_slides(c, c->first_row[contacts]);
  return status;
}

/* Largest entry of G (impulse - held) in the contacts' rows, relative to their offsets. */
static double moved(const nsdae_contacts *c, const double *impulse)
{
  int columns = contact_columns(c);
  double most = 0, size = 0;
  for (int i = 0; i < columns; i++) {
    double sum = 0;
    for (int j = 0; j < c->slides.count; j++)
      sum += delassus_at(c, i, columns + j) * (impulse[j] - c->cones.held[j]);
    most = fmax(most, fabs(sum));
    size = fmax(size, fabs(c->cones.free[i]));
  }
  return size > 0 ? most / size : most;
}

/* Block Gauss-Seidel: contacts with the frictional joints held, then those with the contacts held,
 * until the impulses of the joints no longer move the contacts. */
static int solve_in_turn(nsdae_contacts *c, const double *lambda)
{
  nsdae_cones *s = &c->cones;
  double *impulse = c->delassus.impulse + contact_columns(c), worst = 0, change = INFINITY;
  double enough = 0.1 * c->lcp.options.tol;
  size_t bytes = (size_t)c->slides.count * sizeof *impulse;
  memcpy(s->free, c->delassus.offset, (size_t)c->columns * sizeof *s->free);
  memset(impulse, 0, bytes);
  for (int round = 0; round < ROUNDS && !(change <= enough); round++) {
    hold(c, contact_columns(c), c->slides.count, impulse);
    /* sharper than what the joints are held to, else neither stands */
    int status = solve_contacts(c, 0.1 * enough);
    if (status == NSDAE_E_LCP) status = solve_contacts(c, c->lcp.options.tol);
    if (status < 0) return status;
    worst = s->info.residual;
    memcpy(s->held, impulse, bytes);
    status = solve_slides(c, lambda);
    if (status < 0) return status;
    change = moved(c, impulse);
  }
  c->lcp.info.residual = fmax(worst + change, c->lcp.info.residual);
  return change <= enough ? NSDAE_OK : NSDAE_E_LCP;
}

/* ---- interface */

int nsdae_cones_solve(nsdae_contacts *c, const double *lambda)
{
  nsdae_cones *s = &c->cones;
  int loaded = nsdae_slides_loaded(c);
  if (loaded) set_values(c, 0);
  nsdae_friction_options_default(&s->options);
  s->options.refine = REFINE;
  s->options.budget = nsdae_accuracy_budget(&c->lcp.accuracy, c->lcp.options.tol, c->active_count);
  recall(c);
  int status = loaded ? solve_in_turn(c, lambda)
                      : nsdae_slides_limited(c, lambda, NSDAE_BOUND_CONE, solve_with_joints);
  status = nsdae_contacts_accept(c, status);
  if (status < 0) return status;
  memcpy(c->lcp.x, s->r, (size_t)contact_columns(c) * sizeof *s->r);
  return NSDAE_OK;
}

int nsdae_cones_improve(nsdae_contacts *c, double *impulse)
{
  nsdae_cones *s = &c->cones;
  size_t bytes = (size_t)contact_columns(c) * sizeof *impulse;
  if (!s->solver || c->slides.count > 0) return 0;
  for (int a = 0; a < c->active_count; a++)
    if (c->law[a].kind == NSDAE_SLIDING) return 0;
  set_values(c, 0);
  for (int a = 0; a < c->active_count; a++) s->mu[a] = c->system->contact[c->active[a]].mu;
  nsdae_friction_options_default(&s->options);
  s->options.refine = REFINE;
  s->options.budget = IMPROVE;
  memcpy(s->r, impulse, bytes);
  if (solve_contacts(c, c->lcp.options.tol) < 0) return 0;
  memcpy(impulse, s->r, bytes);
  return 1;
}

int nsdae_cones_rest(nsdae_contacts *c, double *impulse)
{
  nsdae_cones *s = &c->cones;
  size_t bytes = (size_t)contact_columns(c) * sizeof *impulse;
  if (c->slides.count > 0 || s->most == 0 || c->active_count == 0) return 0;
  for (int a = 0; a < c->active_count; a++)
    if (c->law[a].columns != 3) return 0;
  set_values(c, 0);
  for (int a = 0; a < c->active_count; a++) s->mu[a] = c->system->contact[c->active[a]].mu;
  nsdae_friction_options_default(&s->options);
  s->options.stages = NSDAE_FRICTION_SOCP_INTERIOR_POINT | NSDAE_FRICTION_ITERATIVE_REFINEMENT;
  s->options.budget = IMPROVE;
  memset(s->r, 0, bytes);
  if (solve_contacts(c, c->lcp.options.tol) < 0) return 0;
  double still = 10 * s->info.residual * nsdae_largest(contact_columns(c), c->delassus.offset);
  if (!(nsdae_largest(contact_columns(c), s->u) <= still)) return 0;
  memcpy(impulse, s->r, bytes);
  return 1;
}

/* Of a complementarity problem G and the offset are still there; its velocities are G r + offset.
 */
int nsdae_cones_describe(nsdae_contacts *c)
{
  nsdae_cones *s = &c->cones;
  if (nsdae_cones_any(c)) return NSDAE_OK;
  if (c->slides.count > 0 || c->active_count > s->room) return NSDAE_E_STATE;
  for (int a = 0; a < c->active_count; a++)
    if (c->law[a].kind == NSDAE_SLIDING) return NSDAE_E_STATE;
  size_t bytes = (size_t)contact_columns(c) * sizeof *s->q;
  set_values(c, 0);
  memcpy(s->q, c->delassus.offset, bytes);
  memcpy(s->r, c->delassus.impulse, bytes);
  memcpy(s->u, c->delassus.offset, bytes);
  nsdae_add_product(c->columns, contact_columns(c), c->delassus.G, s->r, s->u);
  memset(s->guess, 0, bytes);
  nsdae_friction_options_default(&s->options);
  s->options.tol = c->lcp.options.tol;
  return NSDAE_OK;
}

void nsdae_cones_describe_one(nsdae_cones *s, int rows, double mu, const double *G, const double *q,
                              const double *x)
{
  set_pattern(s, 1);
  s->rows[0] = rows;
  s->mu[0] = mu;
  for (int i = 0; i < rows; i++) {
    s->q[i] = s->u[i] = q[i];
    s->r[i] = x[i];
    s->guess[i] = 0;
    for (int j = 0; j < rows; j++) {
      s->W[j * rows + i] = G[i * rows + j];
      s->u[i] += G[i * rows + j] * x[j];
    }
  }
  nsdae_friction_options_default(&s->options);
}

/* Where the slip is nearer to zero than the impulse to the edge of the cone, it sticks; so it does
 * with a slip of rounding size. */
int nsdae_cones_mode(const nsdae_contacts *c, int a)
{
  const nsdae_cones *s = &c->cones;
  int first = c->first_column[a], columns = c->law[a].columns;
  const double *r = s->r + first, *u = s->u + first;
  double size = 0, d = 0;
  if (!(r[0] > 0)) return NSDAE_MODE_OPEN;
  if (columns == 1) return NSDAE_MODE_SLIP;
  for (int j = 0; j < columns; j++) {
    size = fmax(size, fabs(c->delassus.offset[first + j]));
    d += delassus_at(c, first + j, first + j) / columns;
  }
  double slip = hypot(u[1], u[2]), margin = d * (s->mu[a] * r[0] - hypot(r[1], r[2]));
  return slip > fmax(margin, s->options.tol * size) ? NSDAE_MODE_SLIP : NSDAE_MODE_STICK;
}
