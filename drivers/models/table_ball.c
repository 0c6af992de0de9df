/* A ball that bounces on a table which may move; q = [y].
 *
 *   M = m,  F = -m g,  g_N = y - h(t),  w_N = -h',  the contact's acceleration without v': -h'' */
#include "table_ball.h"

#include "model_names.h"

/* The table at t. */
static void find_table(const table_ball *b, double t, double h[3])
{
  h[0] = h[1] = h[2] = 0;
  if (b->table) b->table(b, t, h);
}

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const table_ball *b = user;
  (void)t;
  (void)q;
  (void)ldm;
  M[0] = b->m;
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const table_ball *b = user;
  (void)t;
  (void)q;
  (void)v;
  F[0] = -b->m * b->g;
  return 0;
}

static int gap(double t, const double *q, double *g_N, void *user)
{
  double h[3];
  find_table(user, t, h);
  g_N[0] = q[0] - h[0];
  return 0;
}

static int gap_normal(double t, const double *q, double *W, int ldw, void *user)
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
  double h[3];
  (void)q;
  (void)w_t;
  find_table(user, t, h);
  w_n[0] = -h[1];
  return 0;
}

static int contact_acceleration(double t, const double *q, const double *v, double *omega_n,
                                double *omega_t, double *omega_s, void *user)
{
  double h[3];
  (void)q;
  (void)v;
  (void)omega_t;
  (void)omega_s;
  find_table(user, t, h);
  omega_n[0] = -h[2];
  return 0;
}

static int potential(double t, const double *q, double *energy, void *user)
{
  const table_ball *b = user;
  (void)t;
  *energy = b->m * b->g * q[0];
  return 0;
}

int table_ball_build(table_ball *b, const char *table_name, nsdae_system **system,
                     nsdae_error *error)
{
  const nsdae_dims dims = {.nq = 1, .k = 1};
  const model_name names[] = {{NSDAE_NAME_COORDINATE, "y", "m"},
                              {NSDAE_NAME_CONTACT, table_name, "m"}};
  int status = nsdae_system_create(&dims, system, error);
  if (status < 0) return status;
  nsdae_system_set_user(*system, b);
  MODEL_NAMES(*system, names);
  nsdae_system_set_mass(*system, mass);
  nsdae_system_set_force(*system, force);
  nsdae_system_set_gap(*system, gap);
  nsdae_system_set_gap_normal(*system, gap_normal);
  nsdae_system_set_contact_bias(*system, contact_bias);
  nsdae_system_set_contact_acceleration(*system, contact_acceleration);
  nsdae_system_set_potential(*system, potential);
  return nsdae_system_set_contact(*system, 0, 0, b->e_N, 0);
}
