/* Moreau's midpoint rule (J.-J. Moreau, 1988; the rival of Zhang, Gu and Sun, section 4.4):
 *
 *   q_m = q_0 + h/2 v_0,  t_m = t_0 + h/2;  M, Phi_q, W and the closed contacts g_N <= 0 at
 *   (t_m, q_m), F at (t_m, q_m, v_0), v(-) = W^T v_0 + w
 *   M (v_1 - v_0) + Phi_q^T Lambda - W Lambda_c = h F,  Phi_q v_1 + Phi_t = 0,  contact laws
 *   q_1 = q_m + h/2 v_1
 *
 * Phi_t is that of (t_1, q_m): a driven coordinate moves by h/2 (f'(t_0) + f'(t_1)). With Phi_t at
 * t_m it would be late by h/2 f', and each projection would shift it by h^2/4 f'' under what it
 * carries.
 *
 * Of first order; explicit: one evaluation and one LCP a step. */
#include <string.h>

#include "stepper.h"

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
  int status = to_middle(&step);
  if (status == NSDAE_OK) status = close_contacts(&step);
  if (status == NSDAE_OK) status = nsdae_problem_factor(&step.tools->problem, middle, 0);
  if (status < 0) return status;
  nsdae_stepper_momentum(&s->system->blocks, middle->M, step.start->v, step.h, middle->F, s->r);
  status = nsdae_step_impact(&step, middle, middle->M, s->r, NULL, s->v);
  return status < 0 ? status : to_end(&step);
}

const nsdae_stepping nsdae_stepping_moreau = {.name = "moreau",
                                              .summary =
                                                  "Moreau's midpoint rule: first order, explicit",
                                              .lay = nsdae_stepper_lay,
                                              .advance = advance,
                                              .closes = 1};
