/* Bodies on joints with the ground: run by every method, against a closed form. */
#ifndef NSDAE_TESTS_HUNG_BODIES_H
#define NSDAE_TESTS_HUNG_BODIES_H

#include "check.h"

#include <nsdae/nsdae.h>

enum { NQ_MAX = 28, NV_MAX = 24 };

/* The state at the end of a run. */
typedef struct ending {
  double q[NQ_MAX], v[NV_MAX];
  double last;    /* time of the last impact */
  double changed; /* time of the last change of a mode */
  double drift;   /* the largest of the records */
  int impacts;
} ending;

static inline int keep(const nsdae_record *r, nsdae_error *error, void *user)
{
  ending *e = user;
  (void)error;
  for (int i = 0; i < r->impacts; i++) e->last = r->impact[i].time;
  if (r->changes > 0) e->changed = r->change[r->changes - 1].time;
  e->impacts += r->impacts;
  e->drift = fmax(e->drift, r->constraint_drift);
  return 0;
}

/* Runs and destroys the bodies. */
static inline ending run(nsdae_bodies *b, int method, double dt, double t_end)
{
  nsdae_system *system;
  nsdae_sim *sim;
  nsdae_record r;
  nsdae_dims dims;
  nsdae_sim_options o;
  ending e = {.last = -1};
  double q[NQ_MAX], v[NV_MAX];
  int status = nsdae_bodies_system(b, &system);
  if (status < 0) fail_msg("%s", nsdae_bodies_error(b)->text);
  nsdae_bodies_get_dims(b, &dims);
  nsdae_bodies_get_start(b, q, v);
  nsdae_sim_options_default(&o);
  o.method = method;
  o.dt = dt;
  o.rtol = 1e-12;
  o.atol = 1e-13;
  assert_int_equal(nsdae_sim_create(system, &o, &sim, NULL), NSDAE_OK);
  nsdae_sim_observe(sim, keep, &e);
  status = nsdae_sim_init(sim, 0, q, v);
  if (status >= 0) status = nsdae_sim_run(sim, t_end);
  if (status < 0) fail_msg("%s", nsdae_sim_error(sim)->text);
  nsdae_sim_get_record(sim, &r);
  memcpy(e.q, r.q, (size_t)dims.nq * sizeof *e.q);
  memcpy(e.v, r.v, (size_t)dims.nv * sizeof *e.v);
  nsdae_sim_destroy(&sim);
  nsdae_system_destroy(&system);
  nsdae_bodies_destroy(&b);
  return e;
}

static inline nsdae_bodies *create(int d, double x, double y, double z)
{
  nsdae_bodies *b;
  const double gravity[3] = {x, y, z};
  assert_int_equal(nsdae_bodies_create(d, &b, NULL), NSDAE_OK);
  assert_int_equal(nsdae_bodies_set_gravity(b, gravity), NSDAE_OK);
  return b;
}

/* A body and its joint with the ground at the point (0, 0, 0), along or about z (plane: x). */
static inline int hang(nsdae_bodies *b, int d, int kind, nsdae_rigid_body body)
{
  if (body.mass == 0) body.mass = 2;
  for (int i = 0; i < 3; i++)
    if (body.inertia[i] == 0) body.inertia[i] = 0.5;
  int number = nsdae_bodies_add(b, &body);
  return nsdae_bodies_add_joint(b, &(nsdae_joint){.kind = kind,
                                                  .body = {NSDAE_GROUND, number},
                                                  .axis = {d == 2, 0, d == 3},
                                                  .cross = {d == 3},
                                                  .ratio = 0.3});
}

/* The angle about z of a body that turns about z. */
static inline double angle_of(int d, const double *q)
{
  return d == 2 ? q[2] : 2 * atan2(q[6], q[3]);
}

/* The steps of time stepping are 2e-3, 5e-4 and 1.25e-4: all in the long form, the first two in the
 * short one, the first under sanitizers. */
static inline double smallest_step(void)
{
  return getenv("NSDAE_LONG") ? 1e-4 : test_share() > 1 ? 1e-3 : 4e-4;
}

/* Errors of the methods: event to 1e-10 (its dt is that of the records); time stepping at most
 * bound dt. */
typedef double (*error_fn)(int d, int method, double dt);

static inline void judge(error_fn error, int d, double bound)
{
  assert_at_most(error(d, NSDAE_METHOD_EVENT, 0.05), 1e-10);
  for (double dt = 2e-3; dt > smallest_step(); dt /= 4) {
    assert_at_most(error(d, NSDAE_METHOD_MOREAU, dt), bound * dt);
    assert_at_most(error(d, NSDAE_METHOD_IMPLICIT, dt), bound * dt);
  }
}

#endif
