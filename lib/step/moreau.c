/* Moreau's midpoint rule (J.-J. Moreau, 1988; the rival of Zhang, Gu and Sun, section 4.4):
 *
 *   q_m = q_0 + h/2 v_0,  t_m = t_0 + h/2;  M, Phi_q, W and the closed contacts g_N <= 0 at
 *   (t_m, q_m), F at (t_m, q_m, u_m), v(-) = W^T v_0 + w
 *   M (v_1 - v_0) + Phi_q^T Lambda - W Lambda_c = h F,  Phi_q v_1 + Phi_t = 0,  contact laws
 *   q_1 = q_m + h/2 v_1;  quaternions move by the exponential map (exponential_map.h)
 *
 * With constraints u_m = v_0. Without, it is the midpoint of a step without contacts:
 *
 *   M (u - v_0) = h F(t_m, q_m, u_m),   u_m = (v_0 + u) / 2
 *
 * The implicit midpoint rule keeps quadratic invariants (Cooper, IMA J. Numer. Anal. 7 (1987) 1):
 * gyroscopic forces, which have no power, leave u^T M u as it was. With F at v_0 they raise it by
 * the square of the angle per step. Contacts with e = 0 and w = 0 take energy from u: v_1 is an
 * M-projection, v_1^T M v_1 <= u^T M u. Constraints would, too, and brake a rotor that is not
 * balanced.
 *
 * Phi_t is that of (t_1, q_m): a driven coordinate moves by h/2 (f'(t_0) + f'(t_1)). With Phi_t at
 * t_m it would be late by h/2 f', and each projection would shift it by h^2/4 f'' under what it
 * carries.
 *
 * Of first order; one evaluation of all but F, and one LCP a step. */
#include <math.h>
#include <string.h>

#include "dense.h"
#include "exponential_map.h"
#include "stepper.h"

/* u_m is found by substitution, which contracts by h |M^-1 dF/dv| / 2: of a free body at most half
 * the angle of its rotation. Of a block without convergence it is found in parts of the step, twice
 * as many each time: 64 are enough for 64 rad. If F jumps with v, or changes faster, it is v_0. */
enum { PARTS = 64, SUBSTITUTIONS = 64 };

/* A change that does not decrease is rounding of F if it is below this: of terms that are up to 1e6
 * times larger than M v / h. */
static const double ROUNDING = 1e-10;

enum {
  FREE_TERMS = NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_JACOBIAN | NSDAE_TERM_GAP,
  CLOSED_TERMS =
      NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS | NSDAE_TERM_SLIDE | NSDAE_TERM_BOUND
};

static int to_middle(const nsdae_step *step)
{
  nsdae_stepper *s = step->tools;
  const nsdae_terms *start = step->start;
  int status = nsdae_kinematics_at(start, start->v, s->qdot[0]);
  nsdae_units_move(s->units, s->system->dims.nq, start->q, step->h / 2, s->qdot[0], s->q);
  nsdae_terms_at(&s->middle, start->t + step->h / 2, s->q, start->v);
  if (status == NSDAE_OK) status = nsdae_terms_need(&s->middle, FREE_TERMS);
  if (status < 0 || s->system->dims.m == 0) return status;
  nsdae_terms_at(step->end, step->t_end, s->q, start->v);
  status = nsdae_terms_need(step->end, NSDAE_TERM_PHI_T);
  memcpy(s->middle.constraint.phi_t, step->end->constraint.phi_t,
         (size_t)s->system->dims.m * sizeof *s->middle.constraint.phi_t);
  return status;
}

static int close_contacts(const nsdae_step *step)
{
  nsdae_terms *middle = &step->tools->middle;
  int status = nsdae_step_close(step, middle);
  if (status < 0 || !nsdae_problem_any(&step->tools->problem)) return status;
  status = nsdae_terms_need(middle, CLOSED_TERMS);
  if (status < 0) return status;
  nsdae_problem_before(&step->tools->problem, middle, step->start->v, 0);
  nsdae_problem_bound(&step->tools->problem, step->h, middle, 0, middle);
  return nsdae_problem_position(&step->tools->problem, middle, step->h, 0);
}

typedef struct substitution {
  double *v, *u_m;   /* nv: at the start of a part and in its middle */
  double *F;         /* nv: mean of the parts */
  double *last;      /* of each block the change before, or FOUND or FAILED */
  const double *now; /* F at v_0, then at u_m */
  double tol;
} substitution;

/* A block has converged in this step, or not yet: then its u_m is v_0. */
static const double FOUND = -1, FAILED = -2;

/* x^T M x */
static double square_of(int n, const double *M, int diagonal, const double *x)
{
  double sum = 0;
  for (int j = 0; j < n; j++)
    for (int i = diagonal ? j : 0; i < (diagonal ? j + 1 : n); i++)
      sum += x[i] * M[i + (long)j * n] * x[j];
  return sum;
}

static void copy_block(const nsdae_blocks *blocks, int b, const double *from, double *to)
{
  memcpy(to + blocks->first[b], from + blocks->first[b],
         (size_t)nsdae_blocks_size(blocks, b) * sizeof *to);
}

/* u_m := v + h/2 M^-1 F of a block and a part of length h, with F at u_m. Returns the change if it
 * is to go on, relative in the norm of M: there a gyroscopic map is normal, each change is less
 * than the last. */
static double substitute(const nsdae_step *step, const substitution *u, int b, double h)
{
  nsdae_stepper *s = step->tools;
  const nsdae_blocks *blocks = &s->system->blocks;
  const int first = blocks->first[b], n = nsdae_blocks_size(blocks, b);
  const double *M = s->middle.M + blocks->square[b], *v = u->v + first;
  const nsdae_block_factor factor = {n, nsdae_la_is_diagonal(n, M, n),
                                     s->mean.M + blocks->square[b]};
  double *x = s->r + first, *u_m = u->u_m + first, last = u->last[b];
  memcpy(x, u->now + first, (size_t)n * sizeof *x);
  nsdae_blocks_solve(&factor, x);
  for (int i = 0; i < n; i++) {
    x[i] = v[i] + h / 2 * x[i];
    u_m[i] -= x[i];
  }
  double change = sqrt(square_of(n, M, factor.diagonal, u_m));
  if (change > 0) change /= sqrt(square_of(n, M, factor.diagonal, x));
  memcpy(u_m, x, (size_t)n * sizeof *x);
  u->last[b] = change;
  if (change < last) return change;
  if (change <= ROUNDING) return 0;
  u->last[b] = FAILED;
  copy_block(blocks, b, step->start->v, u->u_m);
  return INFINITY; /* the others go on with F at this u_m */
}

/* F at u_m, by the terms of the end: those of the middle remain at v_0. */
static int evaluate(const nsdae_step *step, substitution *u)
{
  nsdae_terms_set_velocity(step->end, u->u_m);
  u->now = step->end->F;
  return nsdae_terms_need(step->end, NSDAE_TERM_FORCE);
}

/* One part: u_m, then F and v of its end. */
static int find_midpoint(const nsdae_step *step, substitution *u, int parts)
{
  const nsdae_blocks *blocks = &step->tools->system->blocks;
  double most = INFINITY;
  for (int k = 0; k < SUBSTITUTIONS && most > u->tol; k++) {
    most = 0;
    for (int b = 0; b < blocks->count; b++)
      if (u->last[b] >= 0) most = fmax(most, substitute(step, u, b, step->h / parts));
    int status = most == 0 ? NSDAE_OK : evaluate(step, u);
    if (status < 0) return status;
  }
  for (int b = 0; b < blocks->count; b++) {
    if (!(u->last[b] >= 0)) continue;
    if (!(u->last[b] <= fmax(u->tol, ROUNDING))) {
      u->last[b] = FAILED;
      copy_block(blocks, b, step->start->v, u->u_m);
      continue;
    }
    for (int i = blocks->first[b]; i < blocks->first[b + 1]; i++) {
      u->F[i] += u->now[i] / parts;
      u->v[i] = 2 * u->u_m[i] - u->v[i];
    }
  }
  return NSDAE_OK;
}

/* The step in parts, of the blocks that failed before. Returns how many fail again, or a status. */
static int try_parts(const nsdae_step *step, substitution *u, int parts)
{
  const nsdae_blocks *blocks = &step->tools->system->blocks;
  int status = NSDAE_OK, failed = 0;
  for (int b = 0; b < blocks->count; b++) {
    if (u->last[b] != FAILED) continue;
    u->last[b] = INFINITY;
    copy_block(blocks, b, step->start->v, u->v);
    for (int i = blocks->first[b]; i < blocks->first[b + 1]; i++) u->F[i] = 0;
  }
  for (int k = 0; k < parts && status == NSDAE_OK; k++) {
    for (int b = 0; b < blocks->count; b++) {
      if (!(u->last[b] >= 0)) continue;
      u->last[b] = INFINITY;
      copy_block(blocks, b, u->v, u->u_m);
    }
    if (parts > 1) status = evaluate(step, u);
    if (status == NSDAE_OK) status = find_midpoint(step, u, parts);
  }
  for (int b = 0; b < blocks->count; b++) {
    failed += u->last[b] == FAILED;
    if (u->last[b] >= 0) u->last[b] = FOUND;
  }
  return status < 0 ? status : failed;
}

/* Factors M. Returns 0, or 1 if a block is not positive definite, which is refused later. */
static int begin_substitution(const nsdae_step *step, const substitution *u)
{
  nsdae_stepper *s = step->tools;
  const nsdae_blocks *blocks = &s->system->blocks;
  int singular = 0;
  for (int b = 0; b < blocks->count && !singular; b++) {
    nsdae_block_factor factor = {.L = s->mean.M + blocks->square[b]};
    singular = nsdae_blocks_factor(blocks, b, s->middle.M, &factor) != 0;
    u->last[b] = FAILED;
  }
  return singular;
}

/* F of the middle := that at u_m; it is at v_0 before. */
static int midpoint_force(const nsdae_step *step)
{
  nsdae_stepper *s = step->tools;
  nsdae_terms *T = &s->middle;
  const nsdae_blocks *blocks = &s->system->blocks;
  substitution u = {s->size, s->v, s->mean.F, s->v_other, T->F, s->options->iteration_tol};
  int failed = 1;
  if (s->system->dims.m > 0 || begin_substitution(step, &u) != 0) return NSDAE_OK;
  memcpy(u.u_m, step->start->v, (size_t)s->system->dims.nv * sizeof *u.u_m);
  nsdae_terms_at(step->end, nsdae_terms_time(T), T->q, u.u_m);
  for (int parts = 1; failed > 0 && parts <= PARTS; parts *= 2) failed = try_parts(step, &u, parts);
  if (failed < 0) return failed;
  for (int b = 0; b < blocks->count; b++)
    if (u.last[b] == FOUND) copy_block(blocks, b, u.F, T->F);
  return NSDAE_OK;
}

static int to_end(const nsdae_step *step)
{
  nsdae_stepper *s = step->tools;
  const nsdae_terms *middle = &s->middle;
  int status = nsdae_kinematics_at(middle, s->v, s->qdot[1]);
  nsdae_units_move(s->units, s->system->dims.nq, middle->q, step->h / 2, s->qdot[1], s->q);
  nsdae_problem_add_linear(&s->problem, middle);
  if (s->system->dims.m > 0) nsdae_result_rate(step->result, middle, s->v);
  nsdae_terms_at(step->end, step->t_end, s->q, s->v);
  return status < 0 ? status : nsdae_step_end(step);
}

static int advance(void *own, const nsdae_state *state, double t_end, nsdae_result *result)
{
  nsdae_stepper *s = own;
  nsdae_terms *middle = &s->middle;
  const nsdae_step step = nsdae_step_begin(s, state, t_end, result);
  int redundant = 0, status = to_middle(&step);
  if (status == NSDAE_OK) status = close_contacts(&step);
  if (status == NSDAE_OK) status = nsdae_step_judge_rank(&step, middle, &redundant);
  if (status == NSDAE_OK) status = nsdae_problem_factor(&step.tools->problem, middle, redundant);
  if (status == NSDAE_OK) status = midpoint_force(&step);
  if (status < 0) return status;
  nsdae_stepper_momentum(&s->system->blocks, middle->M, step.start->v, step.h, middle->F, s->r);
  status = nsdae_step_impact(&step, middle, middle->M, s->r, NULL, s->v);
  return status < 0 ? status : to_end(&step);
}

const nsdae_stepping nsdae_stepping_moreau = {
    .name = "moreau",
    .summary = "Moreau's midpoint rule: first order, one contact problem a step",
    .lay = nsdae_stepper_lay,
    .advance = advance,
    .closes = 1};
