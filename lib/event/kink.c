#include "event_method.h"

#include <math.h>
#include <string.h>

#include "errors.h"

/* Steps of the integrator follow a normal that turns by far less. */
static const double COSINE = 0.5;

/* The cosine between the normals of contact i at two points, in the metric of M^-1. */
static double cosine(nsdae_event_instant *p, const nsdae_terms *a, const nsdae_terms *b, int i)
{
  const nsdae_blocks *blocks = &a->system->blocks;
  const nsdae_rows *of[] = {&a->by.normal, &b->by.normal};
  double *z = p->acceleration.size, product[2][2];
  for (int l = 0; l < 2; l++) {
    memset(z, 0, (size_t)a->system->dims.nv * sizeof *z);
    nsdae_rows_add(blocks, of[l], i, 1, z);
    nsdae_kkt_solve_mass(p->roots->phase->setting->kkt, z);
    for (int j = 0; j < 2; j++) product[l][j] = nsdae_rows_dot(blocks, of[j], i, z);
  }
  return product[0][1] / sqrt(product[0][0] * product[1][1]);
}

/* The closed contact, or -1, whose normal turns on the way of that time from the point in work. The
 * end of the step that failed has room for a second point. */
static int find_kink(nsdae_event_instant *p, double *q, double time)
{
  const nsdae_event_phase *phase = p->roots->phase;
  nsdae_terms *here = phase->setting->here, *there = &phase->setting->result->end;
  double *qdot = p->projection.qdot;
  if (nsdae_terms_need(here, NSDAE_TERM_NORMAL) < 0 || nsdae_kinematics_at(here, here->v, qdot) < 0)
    return -1;
  for (int i = 0; i < here->system->dims.nq; i++) q[i] = here->q[i] + time * qdot[i];
  nsdae_terms_at(there, here->t, q, here->v);
  if (nsdae_terms_need(there, NSDAE_TERM_NORMAL) < 0) return -1;
  for (int i = 0; i < here->system->dims.k; i++)
    if (phase->modes.contact[i] != NSDAE_MODE_OPEN && cosine(p, here, there, i) < COSINE) return i;
  return -1;
}

int nsdae_event_explain_strayed(nsdae_event_instant *p, double *q)
{
  const nsdae_event_setting *s = p->roots->phase->setting;
  nsdae_error *error = s->error, kept = *error;
  char called[NSDAE_CALLED_SIZE];
  double dt = s->options->dt;
  int i = find_kink(p, q, -dt);
  if (i < 0) i = find_kink(p, q, dt);
  *error = kept;
  if (i < 0) return error->status;
  nsdae_error_set(error, NSDAE_E_CONVERGENCE, "nsdae_event", "gap_normal",
                  "%s: the gradient of its gap rotates by more than 60 degrees within dt = %g at t "
                  "= %.17g (for example an edge that becomes a flat contact): round the edge, use "
                  "more contacts, or a smaller dt",
                  nsdae_system_called(s->system, NSDAE_NAME_CONTACT, i, called), dt,
                  nsdae_terms_time(s->here));
  error->index = nsdae_system_index(s->system, NSDAE_NAME_CONTACT, i);
  error->time = nsdae_terms_time(s->here);
  return error->status;
}
