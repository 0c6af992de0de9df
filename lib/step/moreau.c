/* Moreau's midpoint rule (J.-J. Moreau, 1988; the rival of Zhang, Gu and Sun, section 4.4):
 *
 *   q_m = q_0 + h/2 v_0,  t_m = t_0 + h/2;  M, Phi_q, W and the closed contacts g_N <= 0 at
 *   (t_m, q_m), F at (t_m, q_m, u_m), v(-) = W^T v_0 + w
 *   M (v_1 - v_0) + Phi_q^T Lambda - W Lambda_c = h F,  Phi_q v_1 + Phi_t = 0,  contact laws
 *   q_1 = q_m + h/2 v_1
 *
 * u_m is the midpoint of a motion with the reactions R of the step before:
 *
 *   M (u - v_0) = h (F(t_m, q_m, u_m) - R),   u_m = (v_0 + u) / 2
 *
 * The implicit midpoint rule keeps quadratic invariants (Cooper, IMA J. Numer. Anal. 7 (1987) 1):
 * gyroscopic forces, which have no power, leave u^T M u as it was, at any speed of rotation. With F
 * at v_0 they raise it by the square of the angle per step. R = h^-1 (Phi_q^T Lambda - W Lambda_c)
 * for the blocks that constraints join, else 0. Without R contacts with e = 0 and w = 0 take energy
 * from u: v_1 is an M-projection, v_1^T M v_1 <= u^T M u. So would constraints, and brake a rotor
 * that is not balanced; with R they have nothing left to project.
 *
 * Phi_t is that of (t_1, q_m): a driven coordinate moves by h/2 (f'(t_0) + f'(t_1)). With Phi_t at
 * t_m it would be late by h/2 f', and each projection would shift it by h^2/4 f'' under what it
 * carries.
 *
 * Of first order; one evaluation of all but F, and one LCP a step. */
#include <math.h>
#include <string.h>

#include "dense.h"
#include "stepper.h"
#include "vector.h"

/* A step is divided into up to this number of intervals for u: by twice as many if substitution
 * does not halve the change of u_m. It contracts by h |M^-1 dF/dv| / 2 over the intervals, of a
 * free body at most half the angle of its rotation. 64 are 64 rad, 10 turns in a step; of what
 * changes faster, and of F that jumps with v, F is taken at the start of the step. */
enum { INTERVALS_MAX = 64 };

/* A change of u_m that is not halved is rounding of F if it is below this: of terms that are up to
 * 1e6 times larger than M v / h. */
static const double ROUNDING = 1e-10;

enum {
  FREE_TERMS = NSDAE_TERM_MASS | NSDAE_TERM_JACOBIAN | NSDAE_TERM_GAP,
  CLOSED_TERMS =
      NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS | NSDAE_TERM_SLIDE | NSDAE_TERM_BOUND
};

static int to_middle(const nsdae_step *step)
{
  nsdae_stepper *s = step->tools;
  const nsdae_terms *start = step->start;
  int status = nsdae_kinematics_at(start, start->v, s->qdot[0]);
  nsdae_move(s->system->dims.nq, start->q, step->h / 2, s->qdot[0], s->q);
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

/* What is kept between steps, behind the bases of the contacts: R, and whether there is one. Its
 * terms are not unique where a contact acts along constraints. */
typedef struct memory {
  double *reaction; /* nv; without constraints 0 */
  int *known;
} memory;

static memory take(const nsdae_stepper *s, nsdae_memory_part *part)
{
  nsdae_stepper_lay(s, part);
  return (memory){nsdae_memory_reals(part, s->system->dims.m > 0 ? (size_t)s->system->dims.nv : 0),
                  nsdae_memory_wholes(part, 1)};
}

static void lay(const nsdae_stepper *s, nsdae_memory_part *part)
{
  (void)take(s, part);
}

/* Factors M into mean.M; 0, or 1 if a block is not positive definite. */
static int factor_mass(nsdae_stepper *s)
{
  const nsdae_blocks *blocks = &s->system->blocks;
  int failed = 0;
  for (int b = 0; b < blocks->count && !failed; b++)
    failed = nsdae_blocks_factor(blocks, b, s->middle.M,
                                 &(nsdae_block_factor){.L = s->mean.M + blocks->square[b]}) != 0;
  return failed;
}

/* u_m := v + scale M^-1 r */
static void midpoint(nsdae_stepper *s, const double *v, double scale, double *r, double *u_m)
{
  const nsdae_blocks *blocks = &s->system->blocks;
  for (int b = 0; b < blocks->count; b++) {
    int n = nsdae_blocks_size(blocks, b);
    const double *M = s->middle.M + blocks->square[b];
    const nsdae_block_factor factor = {n, nsdae_la_is_diagonal(n, M, n),
                                       s->mean.M + blocks->square[b]};
    nsdae_blocks_solve(&factor, r + blocks->first[b]);
  }
  for (int i = 0; i < s->system->dims.nv; i++) u_m[i] = v[i] + scale * r[i];
}

/* F := the mean of F(u_m) over `count` intervals; 1, or 0 if it was not found, or a status.
 * reaction [nv]: R, NULL: 0. */
static int mean_force(const nsdae_step *step, int count, const double *reaction, double *mean)
{
  nsdae_stepper *s = step->tools;
  nsdae_terms *T = &s->middle;
  const int n = s->system->dims.nv;
  double *v = s->size, *u_m = s->v, *r = s->r, *F = s->v_other;
  const size_t bytes = (size_t)n * sizeof *v;
  memcpy(v, step->start->v, bytes);
  memset(mean, 0, bytes);
  for (int k = 0; k < count; k++) {
    double change = INFINITY, last;
    memcpy(u_m, v, bytes);
    do {
      last = change;
      nsdae_terms_set_velocity(T, u_m);
      int status = nsdae_terms_need(T, NSDAE_TERM_FORCE);
      if (status < 0) return status;
      change = 0;
      if (last < INFINITY && memcmp(F, T->F, bytes) == 0) break;
      memcpy(F, T->F, bytes);
      for (int i = 0; i < n; i++) r[i] = reaction ? F[i] - reaction[i] : F[i];
      midpoint(s, v, step->h / count / 2, r, u_m);
      change = nsdae_relative_change(n, u_m, T->v);
    } while (change > s->options->iteration_tol && change <= last / 2);
    if (!(change <= fmax(s->options->iteration_tol, ROUNDING))) return 0;
    if (count == 1) return 1;
    for (int i = 0; i < n; i++) {
      mean[i] += F[i] / count;
      v[i] = 2 * u_m[i] - v[i];
    }
  }
  memcpy(T->F, mean, bytes);
  return 1;
}

/* F of the step. In the first one of a system with constraints it is that at v_0. */
static int force(const nsdae_step *step, const memory *last)
{
  nsdae_stepper *s = step->tools;
  int found = 0, at_start = s->system->dims.m > 0 && !*last->known;
  if (!at_start && factor_mass(s) == 0)
    for (int count = 1; found == 0 && count <= INTERVALS_MAX; count *= 2)
      found = mean_force(step, count, s->system->dims.m > 0 ? last->reaction : NULL, s->mean.F);
  if (found != 0) return found < 0 ? found : NSDAE_OK;
  nsdae_terms_set_velocity(&s->middle, step->start->v);
  return nsdae_terms_need(&s->middle, NSDAE_TERM_FORCE);
}

/* R = (r - M v_1) / h of the momentum r. */
static void keep(const nsdae_step *step, const memory *last)
{
  nsdae_stepper *s = step->tools;
  const nsdae_blocks *blocks = &s->system->blocks;
  const nsdae_rows *J = &s->middle.by.jacobian;
  double *gained = s->v_other; /* M v_1 - r */
  int n = s->system->dims.nv, parts = J->count > 0 ? J->first[J->count] : 0;
  if (J->count == 0) return;
  *last->known = 1;
  for (int i = 0; i < n; i++) gained[i] = -s->r[i];
  nsdae_blocks_add_product(blocks, s->middle.M, s->v, gained);
  memset(last->reaction, 0, (size_t)n * sizeof *gained);
  for (int p = 0; p < parts; p++)
    for (int i = blocks->first[J->block[p]]; i < blocks->first[J->block[p] + 1]; i++)
      last->reaction[i] = -gained[i] / step->h;
}

static int to_end(const nsdae_step *step)
{
  nsdae_stepper *s = step->tools;
  const nsdae_terms *middle = &s->middle;
  int status = nsdae_kinematics_at(middle, s->v, s->qdot[1]);
  nsdae_move(s->system->dims.nq, middle->q, step->h / 2, s->qdot[1], s->q);
  if (s->system->dims.m > 0) nsdae_result_rate(step->result, middle, s->v);
  nsdae_terms_at(step->end, step->t_end, s->q, s->v);
  return status < 0 ? status : nsdae_step_end(step);
}

static int advance(void *own, const nsdae_state *state, double t_end, nsdae_result *result)
{
  nsdae_stepper *s = own;
  nsdae_terms *middle = &s->middle;
  const nsdae_step step = nsdae_step_begin(s, state, t_end, result);
  nsdae_memory_part part = {.real = result->memory.real,
                            .whole = result->memory.whole,
                            .slots = (size_t)s->system->dims.k};
  const memory last = take(s, &part);
  int status = to_middle(&step);
  if (status == NSDAE_OK) status = close_contacts(&step);
  if (status == NSDAE_OK) status = nsdae_problem_factor(&step.tools->problem, middle, 0);
  if (status == NSDAE_OK) status = force(&step, &last);
  if (status < 0) return status;
  nsdae_stepper_momentum(&s->system->blocks, middle->M, step.start->v, step.h, middle->F, s->r);
  status = nsdae_step_impact(&step, middle, middle->M, s->r, NULL, s->v);
  if (status < 0) return status;
  keep(&step, &last);
  return to_end(&step);
}

const nsdae_stepping nsdae_stepping_moreau = {.name = "moreau",
                                              .summary =
                                                  "Moreau's midpoint rule: first order, explicit",
                                              .lay = lay,
                                              .advance = advance,
                                              .closes = 1};
