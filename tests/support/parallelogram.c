#include "parallelogram.h"

#include <math.h>

static const double g = 9.81, r = 0.5, crank = 0.4, bar = 1.2, apart = 0.8;

static int mass(double t, const double *q, double *M, int ldm, void *user)
{
  const parallelogram *p = user;
  (void)t, (void)q;
  for (int i = 0; i < parallelogram_nq(p); i++) {
    int of_bar = i >= 3 * p->cranks, turns = i % 3 == 2;
    double length = of_bar ? 2 * apart : r, m = of_bar ? bar : crank;
    M[i * (ldm + 1)] = turns ? m * length * length / 12 : m;
  }
  return 0;
}

static int force(double t, const double *q, const double *v, double *F, void *user)
{
  const parallelogram *p = user;
  (void)t, (void)q, (void)v;
  for (int i = 0; i <= p->cranks; i++) F[3 * i + 1] = -(i < p->cranks ? crank : bar) * g;
  return 0;
}

static int potential(double t, const double *q, double *energy, void *user)
{
  const parallelogram *p = user;
  (void)t;
  *energy = 0;
  for (int i = 0; i <= p->cranks; i++) *energy += (i < p->cranks ? crank : bar) * g * q[3 * i + 1];
  return 0;
}

/* Of crank i: where its pins are along x, from the middle of the bar. */
static double pin(const parallelogram *p, int i)
{
  return apart * (2.0 * i / (p->cranks - 1) - 1);
}

static int constraint(double t, const double *q, double *phi, void *user)
{
  const parallelogram *p = user;
  const double *c = q + 3 * p->cranks;
  (void)t;
  for (int i = 0; i < p->cranks; i++, phi += 4, q += 3) {
    double X = pin(p, i), sine = r / 2 * sin(q[2]), cosine = r / 2 * cos(q[2]);
    phi[0] = q[0] - sine - X;
    phi[1] = q[1] + cosine;
    phi[2] = q[0] + sine - (c[0] + X * cos(c[2]));
    phi[3] = q[1] - cosine - (c[1] + X * sin(c[2]));
  }
  return 0;
}

static int jacobian(double t, const double *q, double *J, int ldj, void *user)
{
  const parallelogram *p = user;
  const int b = 3 * p->cranks;
  (void)t;
  for (int i = 0; i < p->cranks; i++) {
    double X = pin(p, i), sine = r / 2 * sin(q[3 * i + 2]), cosine = r / 2 * cos(q[3 * i + 2]);
    double *at = J + 4 * i, *x = at + 3 * i * ldj, *y = x + ldj, *phi = y + ldj;
    x[0] = y[1] = x[2] = y[3] = 1;
    phi[0] = -cosine, phi[1] = -sine, phi[2] = cosine, phi[3] = sine;
    at[b * ldj + 2] = at[(b + 1) * ldj + 3] = -1;
    at[(b + 2) * ldj + 2] = X * sin(q[b + 2]);
    at[(b + 2) * ldj + 3] = -X * cos(q[b + 2]);
  }
  return 0;
}

static int bias(double t, const double *q, const double *v, double *phi_t, double *omega,
                void *user)
{
  const parallelogram *p = user;
  const int b = 3 * p->cranks + 2;
  (void)t;
  for (int i = 0; i < p->cranks; i++) {
    double X = pin(p, i), sine = r / 2 * sin(q[3 * i + 2]), cosine = r / 2 * cos(q[3 * i + 2]);
    double w = v[3 * i + 2] * v[3 * i + 2], wb = v[b] * v[b], *o = omega + 4 * i;
    o[0] = sine * w, o[1] = -cosine * w;
    o[2] = -sine * w + X * cos(q[b]) * wb;
    o[3] = cosine * w + X * sin(q[b]) * wb;
    for (int l = 0; l < 4; l++) phi_t[4 * i + l] = 0;
  }
  return 0;
}

static int gap(double t, const double *q, double *distance, void *user)
{
  const parallelogram *p = user;
  (void)t;
  distance[0] = q[3 * p->cranks];
  return 0;
}

static int normal(double t, const double *q, double *W, int ldw, void *user)
{
  const parallelogram *p = user;
  (void)t, (void)q, (void)ldw;
  W[3 * p->cranks] = 1;
  return 0;
}

int parallelogram_nq(const parallelogram *p)
{
  return 3 * p->cranks + 3;
}

nsdae_system *parallelogram_system(parallelogram *p)
{
  const nsdae_dims dims = {.nq = parallelogram_nq(p), .m = 4 * p->cranks, .k = 1};
  nsdae_system *s;
  if (nsdae_system_create(&dims, &s, NULL) < 0) return NULL;
  nsdae_system_set_user(s, p);
  nsdae_system_set_mass(s, mass);
  nsdae_system_set_force(s, force);
  nsdae_system_set_potential(s, potential);
  nsdae_system_set_constraint(s, constraint);
  nsdae_system_set_constraint_jacobian(s, jacobian);
  nsdae_system_set_gap(s, gap);
  if (p->given) nsdae_system_set_constraint_bias(s, bias);
  if (p->given) nsdae_system_set_gap_normal(s, normal);
  nsdae_system_set_contact(s, 0, 0, p->e, 0);
  return s;
}

void parallelogram_start(const parallelogram *p, double phi, double *q)
{
  for (int i = 0; i < p->cranks; i++, q += 3) {
    q[0] = pin(p, i) + r / 2 * sin(phi);
    q[1] = -r / 2 * cos(phi);
    q[2] = phi;
  }
  q[0] = r * sin(phi);
  q[1] = -r * cos(phi);
  q[2] = 0;
}

double parallelogram_frequency(const parallelogram *p)
{
  double m = p->cranks * crank;
  return sqrt((m / 2 + bar) * g * r / ((m / 3 + bar) * r * r));
}

double parallelogram_quarter(const parallelogram *p, double k)
{
  double a = 1, b = sqrt(1 - k * k);
  for (int i = 0; i < 20; i++) {
    double mean = (a + b) / 2;
    b = sqrt(a * b);
    a = mean;
  }
  return acos(-1) / (2 * a * parallelogram_frequency(p));
}
