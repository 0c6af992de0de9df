#include "twin.h"

#include <math.h>
#include <string.h>

#include "random.h"

static double value(const twin *t, const twin_row *r, double time, const double *q)
{
  double sum = -r->rate * time - r->offset;
  for (int s = 0; s < 2; s++)
    for (int j = 0; r->block[s] >= 0 && j < t->size[r->block[s]]; j++) {
      double at = q[t->first[r->block[s]] + j];
      sum += r->a[s][j] * (at + sin(at) / 10);
    }
  return sum;
}

static void gradient(const twin *t, const twin_row *r, const double *q, int s, double *out)
{
  for (int j = 0; j < t->size[r->block[s]]; j++)
    out[j] = r->a[s][j] * (1 + cos(q[t->first[r->block[s]] + j]) / 10);
}

static void draw_row(twin *t, uint64_t *seed, twin_row *r, int a, int b)
{
  r->block[0] = a;
  r->block[1] = b;
  r->rate = r->offset = 0;
  for (int s = 0; s < 2; s++)
    for (int j = 0; j < TWIN_WIDE; j++) r->a[s][j] = random_between(seed, -1, 1) + (j == 0);
  (void)t;
}

static void draw_blocks(twin *t, uint64_t *seed, const twin_kind *kind)
{
  t->blocks = kind->blocks;
  t->nv = 0;
  for (int b = 0; b < t->blocks; b++) {
    int n = 1 + (int)(random_uniform(seed) * (kind->largest > 6 ? 3 : kind->largest));
    if (b == 0 && kind->largest > 6) n = TWIN_WIDE;
    t->size[b] = n;
    t->first[b] = t->nv;
    t->nv += n;
    double scale = pow(10, random_between(seed, -1, 1));
    for (int j = 0; j < n; j++)
      for (int i = 0; i <= j; i++)
        t->M[b][j * n + i] = t->M[b][i * n + j] =
            scale * (i == j ? random_between(seed, 1, 2) : random_between(seed, -0.1, 0.1));
  }
  for (int j = 0; j < t->nv; j++) {
    t->g[j] = random_between(seed, -5, 5);
    t->c[j] = random_between(seed, 0, 0.2);
    t->s[j] = random_between(seed, 0, 2);
    t->q0[j] = random_between(seed, -1, 1);
    t->v0[j] = random_between(seed, -1, 1);
  }
}

static void draw_contact(twin *t, uint64_t *seed, int i, const twin_kind *kind)
{
  int a = (int)(random_uniform(seed) * t->blocks),
      b = (int)(random_uniform(seed) * (t->blocks + 1)) - 1;
  if (b == a) b = -1;
  draw_row(t, seed, &t->gap[i], a, b);
  draw_row(t, seed, &t->tangent[i], a, b);
  if (random_uniform(seed) < 0.3) { /* the ground may come first */
    t->gap[i].block[0] = t->tangent[i].block[0] = b;
    t->gap[i].block[1] = t->tangent[i].block[1] = a;
  }
  t->gap[i].offset = value(t, &t->gap[i], 0, t->q0) - random_between(seed, 0, 0.05);
  t->mu[i] =
      kind->nt > 0 && random_uniform(seed) < 0.8 ? random_between(seed, 0, kind->friction) : 0;
  t->e_n[i] = random_between(seed, 0, kind->restitution);
}

void twin_draw(twin *t, uint64_t seed, const twin_kind *kind)
{
  uint64_t state = seed;
  memset(t, 0, sizeof *t);
  draw_blocks(t, &state, kind);
  t->m = kind->joined ? t->blocks - 1 : 0;
  t->k = kind->k;
  t->nt = kind->nt;
  for (int i = 0; i < t->m; i++) {
    draw_row(t, &state, &t->phi[i], i, i + 1);
    t->phi[i].rate = random_between(&state, -0.1, 0.1);
    t->phi[i].offset = value(t, &t->phi[i], 0, t->q0);
  }
  for (int i = 0; i < t->k; i++) draw_contact(t, &state, i, kind);
  t->f = kind->f;
  for (int j = 0; j < t->f; j++) {
    draw_row(t, &state, &t->slide[j], j, j + 1);
    t->slide_mu[j] = random_between(&state, 0, kind->friction);
  }
  t->id_of_first = 1000;
  t->fail_at = t->wrong_row = t->wrong_contact = -1;
}

/* ---- what both share */

static int force(double time, const double *q, const double *v, double *F, void *user)
{
  const twin *t = user;
  (void)time;
  for (int j = 0; j < t->nv; j++) F[j] = -t->g[j] - t->c[j] * v[j] - t->s[j] * q[j];
  return 0;
}

static int constraint(double time, const double *q, double *phi, void *user)
{
  const twin *t = user;
  for (int i = 0; i < t->m; i++) phi[i] = value(t, &t->phi[i], time, q);
  return 0;
}

static int bias(double time, const double *q, const double *v, double *phi_t, double *omega,
                void *user)
{
  const twin *t = user;
  (void)time;
  for (int i = 0; i < t->m; i++) {
    const twin_row *r = &t->phi[i];
    phi_t[i] = -r->rate;
    omega[i] = 0;
    for (int s = 0; s < 2; s++)
      for (int j = 0; j < t->size[r->block[s]]; j++) {
        int at = t->first[r->block[s]] + j;
        omega[i] -= r->a[s][j] * sin(q[at]) / 10 * v[at] * v[at];
      }
  }
  return 0;
}

/* ---- dense */

static int mass(double time, const double *q, double *M, int ldm, void *user)
{
  const twin *t = user;
  (void)time;
  (void)q;
  for (int b = 0; b < t->blocks; b++)
    for (int j = 0; j < t->size[b]; j++)
      for (int i = 0; i < t->size[b]; i++)
        M[(t->first[b] + j) * ldm + t->first[b] + i] = t->M[b][j * t->size[b] + i];
  return 0;
}

/* Row r into out, with a stride. */
static void spread(const twin *t, const twin_row *r, const double *q, double *out, int stride)
{
  double part[TWIN_WIDE];
  for (int s = 0; s < 2; s++) {
    if (r->block[s] < 0) continue;
    gradient(t, r, q, s, part);
    for (int j = 0; j < t->size[r->block[s]]; j++)
      out[(t->first[r->block[s]] + j) * stride] = part[j];
  }
}

static int jacobian(double time, const double *q, double *J, int ldj, void *user)
{
  const twin *t = user;
  (void)time;
  for (int i = 0; i < t->m; i++) spread(t, &t->phi[i], q, J + i, ldj);
  return 0;
}

static int gap(double time, const double *q, double *g, void *user)
{
  const twin *t = user;
  for (int i = 0; i < t->k; i++) g[i] = value(t, &t->gap[i], time, q);
  return 0;
}

static int normal(double time, const double *q, double *W, int ldw, void *user)
{
  const twin *t = user;
  (void)time;
  for (int i = 0; i < t->k; i++) spread(t, &t->gap[i], q, W + i * ldw, 1);
  return 0;
}

static int tangent(double time, const double *q, double *W, int ldw, void *user)
{
  const twin *t = user;
  (void)time;
  for (int i = 0; i < t->k * t->nt; i++)
    for (int s = 0; s < 2; s++) {
      const twin_row *r = &t->tangent[i / t->nt];
      for (int j = 0; r->block[s] >= 0 && j < t->size[r->block[s]]; j++)
        W[i * ldw + t->first[r->block[s]] + j] = i % t->nt == 0 ? r->a[s][j] : r->a[1 - s][j];
    }
  (void)q;
  return 0;
}

static int slides(double time, const double *q, double *W, int ldw, double *w_s, void *user)
{
  const twin *t = user;
  (void)time, (void)q, (void)w_s;
  for (int i = 0; i < t->f; i++)
    for (int s = 0; s < 2; s++)
      for (int j = 0; j < t->size[i + s]; j++)
        W[i * ldw + t->first[i + s] + j] = t->slide[i].a[s][j];
  return 0;
}

static int slide_rows(double time, const double *q, nsdae_row_list *rows, double *w_s, void *user)
{
  const twin *t = user;
  (void)time, (void)q, (void)w_s;
  for (int i = 0; i < t->f; i++)
    for (int s = 0; s < 2; s++) nsdae_row_add(rows, i, i + s, t->slide[i].a[s]);
  return 0;
}

static void set_slides(const twin *t, nsdae_system *s, int by_rows)
{
  if (t->f > 0 && by_rows) nsdae_system_set_joint_friction_rows(s, slide_rows);
  if (t->f > 0 && !by_rows) nsdae_system_set_frictional_joint_tangent(s, slides);
  for (int j = 0; j < t->f; j++) nsdae_system_set_frictional_joint(s, j, j, t->slide_mu[j]);
}

static int still(double time, const double *q, double *w_n, double *w_t, void *user)
{
  (void)time;
  (void)q;
  (void)w_n;
  (void)w_t;
  (void)user;
  return 0;
}

/* All but M and Phi_q of a system with numbered contacts. */
static nsdae_system *numbered(twin *t)
{
  const nsdae_dims dims = {.nq = t->nv, .m = t->m, .k = t->k, .nt = t->nt, .f = t->f};
  nsdae_system *s;
  if (nsdae_system_create(&dims, &s, NULL) < 0) return NULL;
  nsdae_system_set_user(s, t);
  nsdae_system_set_force(s, force);
  if (t->m > 0) {
    nsdae_system_set_constraint(s, constraint);
    nsdae_system_set_constraint_bias(s, bias);
  }
  if (t->k > 0) {
    nsdae_system_set_gap(s, gap);
    nsdae_system_set_gap_normal(s, normal);
    nsdae_system_set_contact_bias(s, still);
  }
  if (t->k > 0 && t->nt > 0) nsdae_system_set_gap_tangent(s, tangent);
  for (int i = 0; i < t->k; i++) nsdae_system_set_contact(s, i, t->mu[i], t->e_n[i], 0);
  return s;
}

nsdae_system *twin_dense(twin *t)
{
  nsdae_system *s = numbered(t);
  if (!s) return NULL;
  nsdae_system_set_mass(s, mass);
  set_slides(t, s, 0);
  if (t->m > 0) nsdae_system_set_constraint_jacobian(s, jacobian);
  return s;
}

/* ---- by blocks */

static int mass_blocks(double time, const double *q, double *M, void *user)
{
  const twin *t = user;
  (void)time;
  (void)q;
  for (int b = 0; b < t->blocks; b++) {
    size_t square = (size_t)t->size[b] * (size_t)t->size[b];
    memcpy(M, t->M[b], square * sizeof *M);
    M += square;
  }
  return 0;
}

static int constraint_rows(double time, const double *q, nsdae_row_list *rows, void *user)
{
  const twin *t = user;
  double part[TWIN_WIDE];
  (void)time;
  for (int i = 0; i < t->m; i++)
    for (int s = 0; s < 2; s++) {
      gradient(t, &t->phi[i], q, s, part);
      if (s == 0 && i == t->wrong_row) part[0] += 1e-3;
      nsdae_row_add(rows, i, t->phi[i].block[s], part);
    }
  return 0;
}

static void add_contact(const twin *t, int i, double g, const double *q, nsdae_contact_list *list)
{
  const twin_row *N = &t->gap[i], *T = &t->tangent[i];
  double wide[2][3 * TWIN_WIDE];
  nsdae_contact c = {.id = t->id_of_first - 3L * i, .gap = g, .mu = t->mu[i], .e_n = t->e_n[i]};
  for (int s = 0; s < 2; s++) {
    int n = c.block[s] = N->block[s];
    if (n < 0) continue;
    n = t->size[n];
    gradient(t, N, q, s, wide[s]);
    if (i == t->wrong_contact) wide[s][0] += 1e-3;
    for (int d = 0; d < t->nt; d++)
      for (int j = 0; j < n; j++) wide[s][(1 + d) * n + j] = d == 0 ? T->a[s][j] : T->a[1 - s][j];
    if (n > NSDAE_CONTACT_WIDTH) c.wide[s] = wide[s];
    for (int d = 0; d <= t->nt && n <= NSDAE_CONTACT_WIDTH; d++)
      memcpy(c.direction[s][d], wide[s] + d * n, (size_t)n * sizeof(double));
  }
  nsdae_contact_add(list, &c);
}

static int contacts(double time, const double *q, const double *v, double reach,
                    nsdae_contact_list *list, void *user)
{
  twin *t = user;
  int failing = t->calls++ == t->fail_at;
  (void)v;
  if (failing && t->spoil.mu != 0) nsdae_contact_add(list, &t->spoil);
  if (failing && t->fail_code) return t->fail_code;
  for (int i = 0; i < t->k; i++) {
    double g = value(t, &t->gap[i], time, q);
    if (g <= reach) add_contact(t, i, g, q, list);
  }
  return 0;
}

nsdae_system *twin_blocks(twin *t)
{
  const nsdae_dims dims = {.nq = t->nv, .m = t->m, .nt = t->nt, .f = t->f};
  nsdae_system *s;
  if (nsdae_system_create(&dims, &s, NULL) < 0) return NULL;
  nsdae_system_set_user(s, t);
  nsdae_system_set_blocks(s, t->blocks, t->size, t->size);
  nsdae_system_set_mass_blocks(s, mass_blocks);
  nsdae_system_set_force(s, force);
  if (t->m > 0) {
    nsdae_system_set_constraint(s, constraint);
    nsdae_system_set_constraint_rows(s, constraint_rows);
    nsdae_system_set_constraint_bias(s, bias);
  }
  nsdae_system_set_contacts(s, contacts);
  set_slides(t, s, 1);
  return s;
}

nsdae_system *twin_numbered(twin *t, int constraints)
{
  nsdae_system *s = numbered(t);
  if (!s) return NULL;
  nsdae_system_set_blocks(s, t->blocks, t->size, t->size);
  nsdae_system_set_mass_blocks(s, mass_blocks);
  set_slides(t, s, constraints == TWIN_BY_ROWS);
  if (t->m > 0 && constraints == TWIN_BY_ROWS) nsdae_system_set_constraint_rows(s, constraint_rows);
  if (t->m > 0 && constraints == TWIN_BY_MATRIX) nsdae_system_set_constraint_jacobian(s, jacobian);
  return s;
}
