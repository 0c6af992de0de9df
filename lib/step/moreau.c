/* Moreau's midpoint rule (J.-J. Moreau, 1988; the rival of Zhang, Gu and Sun, section 4.4):
 *
 *   q_m = q_0 + h/2 v_0,  t_m = t_0 + h/2;  M, Phi_q, W and the closed contacts g_N <= 0 at
 *   (t_m, q_m), F at (t_m, q_m, v_0), v(-) = W^T v_0 + w
 *   M (v_1 - v_0) + Phi_q^T Lambda - W Lambda_c = h F,  Phi_q v_1 + Phi_t = 0,  contact laws
 *   q_1 = q_m + h/2 v_1
 *
 * Of first order; explicit: one evaluation and one LCP a step. */
#include "stepper.h"

enum {
  FREE_TERMS =
      NSDAE_TERM_MASS | NSDAE_TERM_FORCE | NSDAE_TERM_JACOBIAN | NSDAE_TERM_PHI_T | NSDAE_TERM_GAP,
  CLOSED_TERMS = NSDAE_TERM_NORMAL | NSDAE_TERM_TANGENT | NSDAE_TERM_BIAS | NSDAE_TERM_SLIDE
};

static int to_middle(nsdae_stepper *s, double h)
{
  nsdae_terms *start = &s->start;
  int status = nsdae_stepper_kinematics(s, start->t, start->q, start->v, s->qdot0);
  for (int i = 0; i < s->system->dims.nq; i++) s->q[i] = start->q[i] + h / 2 * s->qdot0[i];
  nsdae_terms_at(&s->middle, start->t + h / 2, s->q, start->v);
  if (status == NSDAE_OK) status = nsdae_terms_need(&s->middle, FREE_TERMS);
  return status;
}

static int close_contacts(nsdae_stepper *s)
{
  nsdae_contacts_close(&s->contacts, &s->middle);
  if (!nsdae_contacts_any(&s->contacts)) return NSDAE_OK;
  int status = nsdae_terms_need(&s->middle, CLOSED_TERMS);
  if (status == NSDAE_OK) nsdae_contacts_before(&s->contacts, &s->middle, s->start.v, 0);
  return status;
}

static int to_end(nsdae_stepper *s, double h)
{
  nsdae_terms *middle = &s->middle;
  int status = nsdae_stepper_kinematics(s, middle->t, middle->q, s->v, s->qdot1);
  for (int i = 0; i < s->system->dims.nq; i++) s->q[i] = middle->q[i] + h / 2 * s->qdot1[i];
  nsdae_terms_at(&s->end, s->t_end, s->q, s->v);
  for (int i = 0; i < s->system->dims.m; i++) s->multiplier[i] = s->impulse[i] / h;
  s->smooth = !nsdae_contacts_any(&s->contacts);
  s->work = nsdae_contacts_work(&s->contacts);
  s->worst_residual = s->contacts.info.residual;
  return status;
}

static int advance(nsdae_stepper *s, double h)
{
  nsdae_terms *middle = &s->middle;
  int status = to_middle(s, h);
  if (status == NSDAE_OK) status = nsdae_stepper_factor(s, middle, middle->M);
  if (status == NSDAE_OK) status = close_contacts(s);
  if (status < 0) return status;
  nsdae_stepper_momentum(middle->M, s->start.v, h, middle->F, s->system->dims.nv, s->r);
  status = nsdae_stepper_impact(s, middle, s->r, s->v);
  return status < 0 ? status : to_end(s, h);
}

const nsdae_stepping nsdae_stepping_moreau = {.name = "moreau",
                                              .summary =
                                                  "Moreau's midpoint rule: first order, explicit",
                                              .advance = advance};
