/* One body or a few, stepped: what a step costs, in instructions, is counted by valgrind (cost.sh),
 * for which it is to do nothing else. It goes with the library and the models of any version that
 * has these calls. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "falling_rod.h"
#include "newtons_cradle.h"
#include "woodpecker.h"

/* A planar body (x, y, angle) in the air, at rest on a rough floor, sliding on it; a ball that
 * bounces (y alone); a pendulum in absolute coordinates (x, y); the body in the air again, turning,
 * with the coordinates of a point at c from its centre: its mass moves; columns of 3 and 10 balls
 * (their heights above contact) that come to rest. */
enum { FALLING, CLOSED, SLIDING, BALL, PENDULUM, TURNING, COLUMN_3, COLUMN_10, SCENES };
enum { MOST = 10 };
static const char *const names[SCENES] = {"falling",  "closed",  "sliding",  "ball",
                                          "pendulum", "turning", "column-3", "column-10"};
static const nsdae_dims dims[SCENES] = {{.nq = 3, .k = 1, .nt = 1}, {.nq = 3, .k = 1, .nt = 1},
                                        {.nq = 3, .k = 1, .nt = 1}, {.nq = 1, .k = 1},
                                        {.nq = 2, .m = 1},          {.nq = 3},
                                        {.nq = 3, .k = 3},          {.nq = 10, .k = 10}};
static const double q0[SCENES][MOST] = {{0, 1e5}, {0}, {0}, {1}, {1, 0}, {0}};
static const double v0[SCENES][MOST] = {{0}, {0}, {1e6}, {0}, {0}, {0, 0, 5}};

/* Models of the drivers, with their parameters. */
static const driver_model *const models[] = {&newtons_cradle_model, &falling_rod_model,
                                             &woodpecker_model};
enum { MODELS = sizeof models / sizeof *models };

static const double gravity = 9.81, dt = 1e-3, c = 0.2;

typedef struct scene {
  int n, height; /* coordinates, the one that is the height */
} scene;

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const double of[3] = {1, 1, 0.1};
  const scene *s = user;
  (void)t;
  (void)q;
  for (int i = 0; i < s->n; i++) M[i * (ldm + 1)] = of[i];
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const scene *s = user;
  (void)t;
  (void)q;
  (void)v;
  F[s->height] = -gravity;
  return 0;
}

/* ---- column */

static int column_mass(double t, const double *q, double *M, int ldm, void *user)
{
  const scene *s = user;
  (void)t;
  (void)q;
  for (int i = 0; i < s->n; i++) M[i * (ldm + 1)] = 1;
  return 0;
}

static int column_force(double t, const double *q, const double *v, double *F, void *user)
{
  const scene *s = user;
  (void)t;
  (void)q;
  (void)v;
  for (int i = 0; i < s->n; i++) F[i] = -gravity;
  return 0;
}

static int column_gap(double t, const double *q, double *g, void *user)
{
  const scene *s = user;
  (void)t;
  for (int i = 0; i < s->n; i++) g[i] = q[i] - (i > 0 ? q[i - 1] : 0);
  return 0;
}

static int column_normal(double t, const double *q, double *W, int ldw, void *user)
{
  const scene *s = user;
  (void)t;
  (void)q;
  for (int i = 0; i < s->n; i++) W[i * (ldw + 1)] = 1;
  for (int i = 1; i < s->n; i++) W[i * ldw + i - 1] = -1;
  return 0;
}

static int column_bias(double t, const double *q, double *w_n, double *w_t, void *user)
{
  const scene *s = user;
  (void)t;
  (void)q;
  (void)w_t;
  for (int i = 0; i < s->n; i++) w_n[i] = 0;
  return 0;
}

static int column_acceleration(double t, const double *q, const double *v, double *n, double *l,
                               double *s, void *user)
{
  (void)v;
  (void)s;
  return column_bias(t, q, n, l, user);
}

static nsdae_system *make_column(const nsdae_dims *d, scene *s)
{
  nsdae_system *system;
  if (nsdae_system_create(d, &system, NULL) < 0) return NULL;
  nsdae_system_set_user(system, s);
  nsdae_system_set_mass(system, column_mass);
  nsdae_system_set_force(system, column_force);
  nsdae_system_set_gap(system, column_gap);
  nsdae_system_set_gap_normal(system, column_normal);
  nsdae_system_set_contact_bias(system, column_bias);
  nsdae_system_set_contact_acceleration(system, column_acceleration);
  for (int i = 0; i < d->k; i++) nsdae_system_set_contact(system, i, 0, 0, 0);
  return system;
}

/* ---- one body */

/* The centre is at (x, y) + c (cos, sin). */
static int turning_mass(double t, const double *q, double *M, int ldm, void *user)
{
  mass(t, q, M, ldm, user);
  M[2] = M[2 * ldm] = -c * sin(q[2]);
  M[2 + ldm] = M[1 + 2 * ldm] = c * cos(q[2]);
  M[2 + 2 * ldm] += c * c;
  return 0;
}

static int turning_force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t;
  (void)user;
  F[0] = c * v[2] * v[2] * cos(q[2]);
  F[1] = c * v[2] * v[2] * sin(q[2]) - gravity;
  F[2] = -c * gravity * cos(q[2]);
  return 0;
}

static int potential(double t, const double *q, double *energy, void *user)
{
  const scene *s = user;
  (void)t;
  *energy = gravity * q[s->height];
  return 0;
}

static int gap(double t, const double *q, double *g, void *user)
{
  const scene *s = user;
  (void)t;
  g[0] = q[s->height];
  return 0;
}

static int normal(double t, const double *q, double *W, int ldw, void *user)
{
  const scene *s = user;
  (void)t;
  (void)q;
  (void)ldw;
  W[s->height] = 1;
  return 0;
}

static int tangent(double t, const double *q, double *W, int ldw, void *user)
{
  (void)t;
  (void)q;
  (void)ldw;
  (void)user;
  W[0] = 1;
  return 0;
}

static int contact_bias(double t, const double *q, double *w_n, double *w_t, void *user)
{
  (void)t;
  (void)q;
  (void)user;
  w_n[0] = 0;
  if (w_t) w_t[0] = 0;
  return 0;
}

static int acceleration(double t, const double *q, const double *v, double *n, double *l, double *s,
                        void *user)
{
  (void)v;
  (void)s;
  return contact_bias(t, q, n, l, user);
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  (void)t;
  (void)user;
  phi[0] = (q[0] * q[0] + q[1] * q[1] - 1) / 2;
  return 0;
}

static int jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  (void)t;
  (void)user;
  J[0] = q[0];
  J[ldj] = q[1];
  return 0;
}

static int bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                void *user)
{
  (void)t;
  (void)q;
  (void)user;
  phi_t[0] = 0;
  omega[0] = v[0] * v[0] + v[1] * v[1];
  return 0;
}

static nsdae_system *make(const nsdae_dims *d, scene *s, int turning)
{
  nsdae_system *system;
  if (nsdae_system_create(d, &system, NULL) < 0) return NULL;
  nsdae_system_set_user(system, s);
  nsdae_system_set_mass(system, turning ? turning_mass : mass);
  nsdae_system_set_force(system, turning ? turning_force : force);
  if (!turning) nsdae_system_set_potential(system, potential);
  if (d->k > 0) {
    nsdae_system_set_gap(system, gap);
    nsdae_system_set_gap_normal(system, normal);
    if (d->nt > 0) nsdae_system_set_gap_tangent(system, tangent);
    nsdae_system_set_contact_bias(system, contact_bias);
    nsdae_system_set_contact_acceleration(system, acceleration);
    nsdae_system_set_contact(system, 0, d->nt > 0 ? 0.3 : 0, 0.5, 0);
  }
  if (d->m > 0) {
    nsdae_system_set_constraint(system, constraint);
    nsdae_system_set_constraint_jacobian(system, jacobian);
    nsdae_system_set_constraint_bias(system, bias);
  }
  return system;
}

static int run(const nsdae_system *system, const char *method, double length, int steps,
               const double *q, const double *v)
{
  nsdae_sim_options options;
  nsdae_sim *sim = NULL;
  nsdae_error error;
  nsdae_sim_options_default(&options);
  options.dt = length;
  int status = nsdae_sim_options_set(&options, "method", method, &error);
  if (status == NSDAE_OK) status = nsdae_sim_create(system, &options, &sim, &error);
  if (status == NSDAE_OK) {
    status = nsdae_sim_init(sim, 0, q, v);
    if (status == NSDAE_OK) status = nsdae_sim_run(sim, steps * length);
    error = *nsdae_sim_error(sim);
  }
  if (status < 0) fprintf(stderr, "%s\n", error.text);
  nsdae_sim_destroy(&sim);
  return status < 0;
}

static int run_scene(int which, const char *method, int steps)
{
  const nsdae_dims *d = &dims[which];
  scene s = {d->nq, which == BALL ? 0 : 1};
  nsdae_system *system = which >= COLUMN_3 ? make_column(d, &s) : make(d, &s, which == TURNING);
  int failed = !system || run(system, method, dt, steps, q0[which], v0[which]);
  nsdae_system_destroy(&system);
  return failed;
}

static int run_model(const driver_model *model, const char *method, int steps)
{
  nsdae_system *system = NULL;
  nsdae_error error;
  double q[MOST] = {0}, v[MOST] = {0};
  nsdae_params_default(model->parameters, model->base);
  if (model->build(model->base, &system, &error) < 0) return 1;
  model->start(model->base, q, v);
  int failed = run(system, method, model->dt > 0 ? model->dt : dt, steps, q, v);
  nsdae_system_destroy(&system);
  return failed;
}

int main(int argc, char **argv)
{
  int which = 0;
  if (argc == 4) {
    while (which < SCENES && strcmp(argv[1], names[which]) != 0) which++;
    if (which < SCENES) return run_scene(which, argv[2], atoi(argv[3]));
    for (int i = 0; i < MODELS; i++)
      if (strcmp(argv[1], models[i]->name) == 0)
        return run_model(models[i], argv[2], atoi(argv[3]));
  }
  fprintf(stderr, "usage: %s SCENE METHOD STEPS\n\nScenes:", argv[0]);
  for (int i = 0; i < SCENES; i++) fprintf(stderr, " %s", names[i]);
  for (int i = 0; i < MODELS; i++) fprintf(stderr, " %s", models[i]->name);
  fprintf(stderr, "\n");
  return 2;
}
