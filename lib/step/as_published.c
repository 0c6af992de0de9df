/* The time-stepping of Zhang, Gu and Sun as it is printed (Fig. 1, Eq. 34). Without a closed
 * contact (g_N(q_0) > 0 for all) a step of Newmark's rule; otherwise the LCP with all terms at
 * (t_0, q_0, v_0) for Lambda and x, then, with dv = M(q_0)^-1 (h F - Phi_q^T Lambda + W Lambda_c),
 *
 *   v~  = v_0 + dv at q_0,   q_1 = q_0 + h/2 (v_0 + v~),   v_1 = v_0 + dv with Phi_q, W at q_1
 *
 * One pass, of first order; v_1 does not satisfy Phi_q(q_1) v_1 + Phi_t = 0. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "newmark.h"
#include "stepper.h"
#include "vector.h"

enum {
  CONTACT_TERMS = NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_JACOBIAN | NSDAE_TERM_PHI_T |
                  NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS | NSDAE_TERM_SLIDE |
                  NSDAE_TERM_BOUND,
  END_TERMS = NSDAE_TERM_JACOBIAN | NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_SLIDE
};

typedef struct printed {
  nsdae_stepper *stepper;
  nsdae_newmark newmark;
  nsdae_arena arena;
} printed;

/* Beside the contacts' warm start: a and lambda of the end of a smooth step, and whether they are
 * there. */
static void lay(const nsdae_stepper *s, nsdae_memory_part *part)
{
  nsdae_stepper_lay(s, part);
  nsdae_memory_reals(part, (size_t)s->system->dims.nv + (size_t)s->system->dims.m);
  nsdae_memory_wholes(part, 1);
}

static void layout(void *object, nsdae_arena *arena)
{
  nsdae_newmark_layout(&((printed *)object)->newmark, arena);
}

static int create(nsdae_stepper *s, void **own)
{
  printed *p = calloc(1, sizeof *p);
  *own = p;
  if (!p) return nsdae_stepper_made(s, NSDAE_E_MEMORY, "implicit-printed");
  p->stepper = s;
  p->newmark = (nsdae_newmark){.system = s->system, .error = s->error, .options = s->options};
  return nsdae_stepper_made(s, nsdae_arena_build(&p->arena, layout, p), "implicit-printed");
}

static void destroy(void *own)
{
  printed *p = own;
  if (!p) return;
  nsdae_arena_release(&p->arena);
  free(p);
}

static void jump(void *own, nsdae_memory *memory)
{
  (void)own;
  memory->whole[memory->wholes - 1] = 0;
}

/* M a + Phi_q^T lambda = r, Phi_q a = c, with c in lambda. */
static int solve_smooth(void *of, nsdae_terms *terms, const double *r, double *a, double *lambda)
{
  const nsdae_step *step = of;
  int status = nsdae_step_factor(step, terms, 0);
  return status < 0 ? status : nsdae_step_free(step, terms, terms->M, r, a, lambda);
}

static int smooth_step(printed *p, const nsdae_step *step)
{
  nsdae_result *result = step->result;
  nsdae_memory *memory = &result->memory;
  /* The settings, which may change between runs; a_0 and lambda_0 are in the memory. */
  nsdae_newmark *N = &p->newmark;
  const nsdae_stepper *s = p->stepper;
  N->tol = s->iteration_tol;
  N->a0 = memory->real;
  N->lambda0 = N->a0 + s->system->dims.nv;
  N->have_start = memory->whole[memory->wholes - 1];
  p->newmark.solve = solve_smooth;
  p->newmark.of = (void *)step;
  int status = nsdae_newmark_step(&p->newmark, step->start, step->end, step->t_end, step->h,
                                  result->multiplier);
  memory->whole[memory->wholes - 1] = p->newmark.have_start;
  result->counters.iterations += p->newmark.iterations;
  result->smooth = 1;
  return status;
}

/* Lambda and x at the start, v~ into s->v. */
static int solve_at_start(const nsdae_step *step)
{
  nsdae_stepper *s = step->tools;
  nsdae_terms *start = step->start;
  int status = nsdae_terms_need(start, CONTACT_TERMS);
  if (status == NSDAE_OK) status = nsdae_step_factor(step, start, 0);
  if (status < 0) return status;
  nsdae_problem_before(&s->problem, start, start->v, 0);
  nsdae_problem_bound(&s->problem, step->h, start, 0, start);
  nsdae_stepper_momentum(&s->system->blocks, start->M, start->v, step->h, start->F, s->r);
  return nsdae_step_impact(step, start, start->M, s->r, s->v);
}

static int positions(const nsdae_step *step)
{
  nsdae_stepper *s = step->tools;
  const nsdae_terms *start = step->start;
  const nsdae_dims *dims = &s->system->dims;
  for (int i = 0; i < dims->nv; i++) s->v_other[i] = (start->v[i] + s->v[i]) / 2;
  int status = nsdae_kinematics_at(start, s->v_other, s->qdot[0]);
  nsdae_move(dims->nq, start->q, step->h, s->qdot[0], s->q);
  nsdae_terms_at(step->end, step->t_end, s->q, s->v);
  if (status == NSDAE_OK) status = nsdae_terms_need(step->end, END_TERMS);
  return status < 0 ? status : nsdae_step_update(step, step->end);
}

/* v_1 = M(q_0)^-1 (M v_0 + h F - Phi_q(q_1)^T Lambda + W(q_1) Lambda_c); s->r holds M v_0 + h F. */
static int velocity_at_end(const nsdae_step *step)
{
  nsdae_stepper *s = step->tools;
  nsdae_problem_add_constraints(&s->problem, step->end, -1, 0, s->impulse, s->r);
  nsdae_problem_add_impulse(&s->problem, step->end, 1, 0, s->r);
  int status = nsdae_problem_solve_mass(&s->problem, step->start, s->r);
  /* where the matrices did not change, v_1 is v~ and not its rounding: a body at rest stays at rest
   */
  for (int i = 0; i < s->system->dims.nv; i++)
    if (fabs(s->r[i] - s->v[i]) <= 64 * DBL_EPSILON * (fabs(s->size[i]) + fabs(s->v[i])))
      s->r[i] = s->v[i];
  nsdae_terms_set_velocity(step->end, s->r);
  return status;
}

static int contact_step(const nsdae_step *step)
{
  nsdae_memory *memory = &step->result->memory;
  memory->whole[memory->wholes - 1] = 0;
  int status = solve_at_start(step);
  if (status == NSDAE_OK) status = positions(step);
  if (status < 0) return status;
  status = velocity_at_end(step);
  return status < 0 ? status : nsdae_step_end(step);
}

static int advance(void *own, const nsdae_state *state, double t_end, nsdae_result *result)
{
  printed *p = own;
  const nsdae_step step = nsdae_step_begin(p->stepper, state, t_end, result);
  int status = nsdae_terms_need(step.start, NSDAE_TERM_GAP);
  if (status == NSDAE_OK) status = nsdae_step_close(&step, step.start);
  if (status < 0) return status;
  return nsdae_problem_any(&p->stepper->problem) ? contact_step(&step) : smooth_step(p, &step);
}

const nsdae_stepping nsdae_stepping_printed = {
    .name = "implicit-printed",
    .summary = "the source paper's one-pass scheme, letter for letter: first order",
    .create = create,
    .destroy = destroy,
    .lay = lay,
    .jump = jump,
    .advance = advance,
    .closes = 1};
