/* The ball in C, for the tests of compiled callbacks. user: its mass, where it is not NULL. */
#include <stddef.h>

static double mass_of(const void *user)
{
  return user ? *(const double *)user : 0.1;
}

int mass(double t, const double *q, double *M, int ldm, void *user)
{
  (void)t, (void)q, (void)ldm;
  M[0] = mass_of(user);
  return 0;
}

int force(double t, const double *q, const double *v, double *F, void *user)
{
  (void)t, (void)q, (void)v;
  F[0] = -mass_of(user) * 9.81;
  return 0;
}

int gap(double t, const double *q, double *g, void *user)
{
  (void)t, (void)user;
  g[0] = q[0];
  return 0;
}

int drive(double t, double *f, void *user)
{
  (void)user;
  f[0] = 2 * t;
  f[1] = 2;
  f[2] = 0;
  return 0;
}

/* Balls on one another, one block each. user: the address of nsdae_contact_add, how many they are.
 */
typedef struct column {
  int (*add)(void *list, const void *contact);
  long n;
} column;

/* As nsdae/contact.h has it. */
typedef struct contact {
  long id;
  int block[2];
  double gap, mu, e_n, e_t, w[3], omega[3];
  int omega_given;
  double direction[2][3][6];
  const double *wide[2];
} contact;

int column_mass_blocks(double t, const double *q, double *M, void *user)
{
  const column *c = user;
  (void)t, (void)q;
  for (long i = 0; i < c->n; i++) M[i] = i % 2 ? 10 : 1;
  return 0;
}

int column_force(double t, const double *q, const double *v, double *F, void *user)
{
  const column *c = user;
  (void)t, (void)q, (void)v;
  for (long i = 0; i < c->n; i++) F[i] = -9.81 * (i % 2 ? 10 : 1);
  return 0;
}

int column_contacts(double t, const double *q, const double *v, double reach, void *list,
                    void *user)
{
  const column *c = user;
  (void)t, (void)v;
  for (long i = 0; i < c->n; i++) {
    contact one = {.id = 100 + i, .block = {(int)i, (int)i - 1}, .e_n = 0.3};
    one.gap = q[i] - (i > 0 ? q[i - 1] : -0.5) - 1;
    one.direction[0][0][0] = 1;
    one.direction[1][0][0] = -1;
    if (one.gap <= reach) c->add(list, &one);
  }
  return 0;
}
