#include "acceleration.h"

#include <math.h>
#include <string.h>

#include "dense.h"
#include "system_impl.h"

void nsdae_event_acceleration_layout(nsdae_event_acceleration *p, nsdae_arena *arena)
{
  const nsdae_dims *d = &p->phase->setting->system->dims;
  long k = d->k, columns = k * (1 + d->nt) + d->f;
  nsdae_contacts_layout(&p->problem, d, arena);
  nsdae_hyperstatic_layout(&p->sharing, d, arena);
  p->law = nsdae_arena_take(arena, k, sizeof *p->law);
  nsdae_impulses_layout(&p->solution, d, arena);
  p->sense = NSDAE_ARENA_INTS(arena, d->f);
  nsdae_arena_doubles(arena, d->nv, (double **[]){&p->a, &p->size, NULL});
  p->lambda = NSDAE_ARENA_DOUBLES(arena, d->m);
  nsdae_arena_doubles(arena, columns, (double **[]){&p->force, &p->xi, NULL});
  p->bound = NSDAE_ARENA_DOUBLES(arena, d->f);
  int **of_contact[] = {&p->is.touching, &p->is.candidate, &p->is.released, &p->is.breakaway,
                        &p->is.stopped,  &p->is.moving,    &p->is.closed};
  int **of_slide[] = {&p->is.slide_breakaway, &p->is.slide_stopped, &p->is.slide_turned};
  for (int i = 0; i < 7; i++) *of_contact[i] = NSDAE_ARENA_INTS(arena, k);
  for (int i = 0; i < 3; i++) *of_slide[i] = NSDAE_ARENA_INTS(arena, d->f);
  p->problem.slides.sense = p->sense;
}

void nsdae_event_acceleration_prepare(nsdae_event_acceleration *p)
{
  const nsdae_event_setting *s = p->phase->setting;
  const nsdae_dims *d = &s->system->dims;
  int edges = nsdae_law_edges_to_start(s->options->polygon);
  p->problem.given = p->law;
  p->problem.cones.most = d->nt == 2 ? d->k : 0;
  const nsdae_accuracy accuracy = {.tol = s->options->contact_tol};
  nsdae_contacts_set(&p->problem, s->system, s->error, &accuracy, edges);
  p->around = d->nt == 2 ? cos(acos(-1) / edges) : 1;
}

/* Of contact i that does not slide: a polygon is put around the friction cone, so that a contact
 * that would leave it does slide. */
static nsdae_law resting(const nsdae_event_acceleration *p, int i)
{
  const nsdae_contacts *c = &p->problem;
  return nsdae_law_make(c->system->dims.nt, c->system->contact[i].mu / p->around, c->edges,
                        c->lcp.edge);
}

/* Fills the direction of sliding of contact i; 0 where it has none. At a slip that was found at
 * zero there is none. */
static int slides(nsdae_event_acceleration *p, int i, int impacted, double size)
{
  const nsdae_event_setting *s = p->phase->setting;
  const nsdae_terms *T = s->here;
  int nt = T->system->dims.nt, slid = 0;
  double v_t[2] = {0}, speed = 0;
  double *direction = p->phase->modes.direction + i * nt;
  if (!(T->system->contact[i].mu > 0)) return 0;
  if (p->is.breakaway[i] && !impacted) return 1;
  for (int l = 0; l < nt; l++) {
    v_t[l] = nsdae_terms_tangent_rate(T, i * nt + l, T->v);
    speed = hypot(speed, v_t[l]);
    slid |= p->phase->modes.contact[i] == NSDAE_MODE_SLIP && direction[l] != 0;
  }
  double slow = 10 * size * (nt == 1 ? p->phase->modes.blur[i] : 1);
  int stopped = !impacted && p->is.stopped[i] && slid && speed <= slow;
  int moves = speed > size && !stopped;
  for (int l = 0; l < nt; l++) direction[l] = moves ? v_t[l] / speed : 0;
  return moves;
}

static int slide_sense(const nsdae_event_acceleration *p, int j, int impacted, double size)
{
  const nsdae_event_setting *s = p->phase->setting;
  const nsdae_event_modes *m = &p->phase->modes;
  if (p->is.slide_breakaway[j] && !impacted) return m->slide_sense[j];
  double speed = nsdae_terms_slide_rate(s->here, j, s->here->v);
  int stopped = !impacted && p->is.slide_stopped[j] && m->frictional_joint[j] == NSDAE_MODE_SLIP &&
                m->slide_sense[j] != 0;
  if (stopped || !(fabs(speed) > size)) return 0;
  return speed > 0 ? 1 : -1;
}

void nsdae_event_set_laws(nsdae_event_acceleration *p, int impacted, double size)
{
  const nsdae_system *s = p->phase->setting->system;
  int nt = s->dims.nt;
  for (int i = 0; i < s->dims.k; i++) {
    if (!p->is.candidate[i]) continue;
    p->is.moving[i] = slides(p, i, impacted, size);
    p->law[i] = p->is.moving[i]
                    ? nsdae_law_sliding(nt, s->contact[i].mu, p->phase->modes.direction + i * nt)
                    : resting(p, i);
  }
  for (int j = 0; j < s->dims.f; j++) p->sense[j] = slide_sense(p, j, impacted, size);
}

static int solve_bounded(nsdae_event_acceleration *p)
{
  nsdae_event_setting *s = p->phase->setting;
  nsdae_terms T = *s->here;
  int n = s->system->dims.nv, m = s->system->dims.m;
  T.w_N = T.omega.N;
  T.w_T = T.omega.T;
  T.frictional_joint.w = T.frictional_joint.omega;
  nsdae_contacts_close_marked(&p->problem, p->is.candidate, &p->solution);
  memcpy(p->a, T.F, (size_t)n * sizeof *p->a);
  memcpy(p->size, T.F, (size_t)n * sizeof *p->size);
  for (int i = 0; i < m; i++) p->lambda[i] = -T.constraint.omega[i];
  nsdae_kkt_solve_mass(s->kkt, p->size);
  int status = nsdae_terms_solve(s->here, s->kkt, 1, p->a, p->lambda);
  if (status == NSDAE_OK) status = nsdae_event_solve(s, &p->problem, &T, p->size, p->a, p->lambda);
  if (status == NSDAE_OK)
    status = nsdae_terms_finite(s->here, "acceleration", NSDAE_NAME_VELOCITY, p->a);
  return status < 0 ? status
                    : nsdae_terms_finite(s->here, "multiplier", NSDAE_NAME_CONSTRAINT, p->lambda);
}

static int solve(nsdae_event_acceleration *p)
{
  const nsdae_terms *T = p->phase->setting->here;
  nsdae_circles circles = nsdae_circles_begin(T, T->frictional_joint.bound, NULL, NSDAE_CIRCLE_PART,
                                              nsdae_largest(T->system->dims.nv, T->F), p->bound);
  int status;
  p->problem.slides.bound = p->bound;
  do status = solve_bounded(p);
  while (nsdae_circles_again(&circles, p->lambda, &status));
  return status;
}

/* Whether nothing that touches moves, and it would from here on, or the problem has no solution. */
static int may_rest(const nsdae_event_acceleration *p, int status)
{
  const nsdae_event_setting *s = p->phase->setting;
  const nsdae_terms *T = s->here;
  const double size = nsdae_event_velocity_size(s), none = 1e-6;
  int touches = 0, n = s->system->dims.nv;
  if (s->system->dims.nt < 2 || (status < 0 && status != NSDAE_E_LCP)) return 0;
  for (int i = 0; i < s->system->dims.k; i++) {
    if (!p->is.candidate[i]) continue;
    touches++;
    if (p->is.moving[i] || fabs(nsdae_terms_normal_rate(T, i, T->v)) > size) return 0;
  }
  return touches > 1 && (status < 0 || nsdae_largest(n, p->a) > none * nsdae_largest(n, p->size));
}

/* Where the polygons' problem was not solved, the cones' may be. */
int nsdae_event_accelerate(nsdae_event_acceleration *p, nsdae_painleve_margin margin)
{
  int status = solve(p);
  p->by_cones = status == NSDAE_E_LCP &&
                nsdae_projected_gauss_seidel_anew(&p->problem, p->phase->modes.direction, p->force,
                                                  p->xi, p->a, p->lambda);
  if (!p->by_cones && may_rest(p, status) &&
      nsdae_cones_rest(&p->problem, p->problem.delassus.impulse))
    p->by_cones = nsdae_projected_gauss_seidel(&p->problem, p->phase->modes.direction, p->force,
                                               p->xi, p->a, p->lambda);
  if (p->by_cones) {
    nsdae_error_clear(p->phase->setting->error);
    nsdae_event_add_residual(p->phase->setting, &p->problem);
  }
  return nsdae_painleve_judge(&p->problem, p->by_cones ? NSDAE_OK : status, !p->by_cones, margin,
                              p->phase->setting->here->t);
}

int nsdae_event_diagnose(nsdae_event_acceleration *p, double t, const double *y)
{
  nsdae_event_setting *s = p->phase->setting;
  nsdae_error kept = *s->error;
  nsdae_event_move(s, t, y);
  int status = nsdae_terms_need(s->here, NSDAE_EVENT_TERMS);
  if (status == NSDAE_OK) status = nsdae_event_factor(s);
  if (status == NSDAE_OK) {
    for (int i = 0; i < s->system->dims.k; i++)
      p->is.candidate[i] = p->phase->modes.contact[i] != NSDAE_MODE_OPEN;
    nsdae_event_set_laws(p, 1, nsdae_event_velocity_size(s));
    status = nsdae_event_accelerate(p, NSDAE_PAINLEVE_NEAR);
  }
  if (status == NSDAE_E_PAINLEVE) return status;
  *s->error = kept;
  return NSDAE_OK;
}

double nsdae_event_acceleration_size(const nsdae_event_acceleration *p)
{
  int n = p->phase->setting->system->dims.nv;
  double most = fmax(nsdae_largest(n, p->a), nsdae_largest(n, p->size));
  return fmax(1e-10 * most, 10 * fmin(p->phase->setting->error_by_differences[1],
                                      NSDAE_EVENT_DIFFERENCES * most));
}

/* ---- painleve */

static const double margins[] = {1e-10, 1e-3};

static const char without_bound[] = "an unbounded contact force";

/* Of a contact or a slide. */
static int tell(const nsdae_contacts *c, int kind, int item, double t, const char *what,
                double coefficient)
{
  char called[NSDAE_CALLED_SIZE];
  t = nsdae_system_time(c->system, t);
  nsdae_error_set(c->error, NSDAE_E_PAINLEVE, "nsdae_event", "mu",
                  "%s has %s at t = %g (Painleve's paradox: friction increases the normal "
                  "force, coefficient %.3g): reduce mu, or use method = implicit (impulses)",
                  nsdae_system_called(c->system, kind, item, called), what, t, coefficient);
  c->error->index = nsdae_system_index(c->system, kind, item);
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

/* Whether the solved problem has another solution with x_i = 0 and y_i > 0 for i = row: one of
 * the problem without this row and column, here y_i = x_i + 1. */
static int has_open_solution(const nsdae_contacts *c, int row)
{
  const nsdae_contact_lcp *lcp = &c->lcp;
  size_t n = (size_t)c->rows, i = (size_t)row;
  double *A = lcp->A, *along = lcp->other, *down = along + n, *x = down + n, *y = x + n;
  double b = lcp->b[i], size = nsdae_largest(c->rows, lcp->b);
  const nsdae_lcp_problem problem = {.n = c->rows, .A = A, .lda = c->rows, .b = lcp->b};
  nsdae_lcp_info info;
  memcpy(down, A + i * n, n * sizeof *A);
  memset(A + i * n, 0, n * sizeof *A);
  for (size_t j = 0; j < n; j++) along[j] = j == i ? down[i] : A[j * n + i], A[j * n + i] = j == i;
  lcp->b[i] = 1;
  memset(x, 0, n * sizeof *x);
  memset(lcp->basis, 0, n * sizeof *lcp->basis);
  int status = nsdae_lcp_solve_in(&problem, &lcp->options, lcp->basis, x, y, &info, lcp->work,
                                  lcp->lwork, lcp->iwork, lcp->liwork);
  for (size_t j = 0; j < n; j++) A[j * n + i] = along[j];
  memcpy(A + i * n, down, n * sizeof *A);
  lcp->b[i] = b;
  return status == NSDAE_OK && b + nsdae_dot(c->rows, along, x) > lcp->options.tol * size;
}

/* Of the j-th slide of the problem: 1 - |D_SS mu|, of what a unit of its multiplier calls for in
 * friction, and that in turn of its multiplier: see slides.h. Up to 0 a slide of known direction
 * has no multiplier, or two. */
static double slide_coefficient(const nsdae_contacts *c, int j)
{
  size_t f = (size_t)c->slides.count, column = (size_t)c->columns - f + (size_t)j;
  return 1 - fabs(c->map.D_S[column * f + (size_t)j] *
                  c->system->frictional_joint[c->slides.number[j]].mu);
}

static int joint_slides(const nsdae_contacts *c, int j)
{
  return c->slides.sense && c->slides.sense[c->slides.number[j]];
}

int nsdae_painleve_twofold(const nsdae_contacts *c, int j)
{
  double coefficient = joint_slides(c, j) ? slide_coefficient(c, j) : 1;
  return coefficient < -margins[NSDAE_PAINLEVE_EXACT] && !(yield_of(c, c->slides.row[j]) > 0);
}

/* The slide that feeds its own multiplier most is to blame. */
static int judge_slides(const nsdae_contacts *c, int status, nsdae_painleve_margin margin, double t)
{
  int unsolved = status == NSDAE_E_LCP || status == NSDAE_E_INFEASIBLE, worst = -1;
  for (int j = 0; j < c->slides.count; j++)
    if (joint_slides(c, j) && (worst < 0 || slide_coefficient(c, j) < slide_coefficient(c, worst)))
      worst = j;
  if (worst < 0) return status;
  double coefficient = slide_coefficient(c, worst);
  int near = fabs(coefficient) <= margins[margin];
  if (unsolved ? coefficient > margins[margin] : margin == NSDAE_PAINLEVE_EXACT || !near)
    return status;
  return tell(c, NSDAE_NAME_FRICTIONAL_JOINT, c->slides.number[worst], t,
              near ? without_bound : "no friction force that solves the equations", coefficient);
}

int nsdae_painleve_judge(const nsdae_contacts *c, int status, int by_rows,
                         nsdae_painleve_margin margin, double t)
{
  int unsolved = status == NSDAE_E_LCP || status == NSDAE_E_INFEASIBLE;
  for (int a = 0; a < c->active_count; a++) {
    int row = c->first_row[a];
    double coefficient = c->lcp.A[(size_t)row * (size_t)c->rows + (size_t)row];
    double least =
        margins[margin] * c->delassus.G[(size_t)c->first_column[a] * (size_t)(c->columns + 1)];
    if (c->law[a].kind != NSDAE_SLIDING || (coefficient > least && !unsolved)) continue;
    if (status == NSDAE_OK && by_rows && yield_of(c, row) > least) continue;
    if (status == NSDAE_OK && margin == NSDAE_PAINLEVE_EXACT && !has_open_solution(c, row))
      continue;
    return tell(c, NSDAE_NAME_CONTACT, c->active[a], t,
                margin == NSDAE_PAINLEVE_NEAR ? without_bound
                : unsolved                    ? "no contact force that solves the equations"
                                              : "two solutions",
                coefficient);
  }
  return judge_slides(c, status, margin, t);
}

int nsdae_painleve_unbounded(const nsdae_contacts *c, int contact, double t, double coefficient)
{
  return tell(c, NSDAE_NAME_CONTACT, contact, t, without_bound, coefficient);
}
