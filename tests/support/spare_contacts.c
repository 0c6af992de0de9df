#include "spare_contacts.h"

#include <string.h>

#include "system_impl.h"

/* As far away as the least gap that no motion of a test comes near. */
static const double FAR = 1e6;

enum { WIDTH = 64 };

static const spare_contacts *at; /* the one at hand */

static const nsdae_system *of(void)
{
  return at->of;
}

int spare_contacts_place(const spare_contacts *spare, int contact)
{
  return spare->first + (1 + spare->between) * contact;
}

int spare_contacts_round(const spare_contacts *spare)
{
  return !spare->of->call.gap_normal && !spare->of->call.contact_acceleration;
}

/* Columns of `each` contact's, from where the system's own are to their places. */
static void spread(const double *from, int rows, int each, double *to, int ld)
{
  for (int i = 0; i < of()->dims.k; i++)
    for (int j = 0; j < each; j++)
      memcpy(to + (size_t)(spare_contacts_place(at, i) * each + j) * (size_t)ld,
             from + (size_t)(i * each + j) * (size_t)rows, (size_t)rows * sizeof *to);
}

static int gap(double t, const double *q, double *g, void *user)
{
  double own[SPARE_MOST] = {0};
  int code = of()->call.gap(t, q, own, user);
  for (int i = 0; i < spare_contacts_place(at, of()->dims.k); i++) g[i] = FAR;
  spread(own, 1, 1, g, 1);
  return code;
}

static int gap_normal(double t, const double *q, double *W, int ldw, void *user)
{
  double own[WIDTH * SPARE_MOST] = {0};
  int n = of()->dims.nv, code = of()->call.gap_normal(t, q, own, n, user);
  spread(own, n, 1, W, ldw);
  return code;
}

static int gap_tangent(double t, const double *q, double *W, int ldw, void *user)
{
  double own[WIDTH * SPARE_MOST * 2] = {0};
  int n = of()->dims.nv, code = of()->call.gap_tangent(t, q, own, n, user);
  spread(own, n, of()->dims.nt, W, ldw);
  return code;
}

static int contact_bias(double t, const double *q, double *w_n, double *w_t, void *user)
{
  double n[SPARE_MOST] = {0}, tangential[2 * SPARE_MOST] = {0};
  int code = of()->call.contact_bias(t, q, n, w_t ? tangential : NULL, user);
  spread(n, 1, 1, w_n, 1);
  if (w_t) spread(tangential, 1, of()->dims.nt, w_t, 1);
  return code;
}

static int contact_acceleration(double t, const double *q, const double *v, double *omega_n,
                                double *omega_t, double *omega_s, void *user)
{
  double n[SPARE_MOST] = {0}, tangential[2 * SPARE_MOST] = {0};
  int code =
      of()->call.contact_acceleration(t, q, v, n, omega_t ? tangential : NULL, omega_s, user);
  spread(n, 1, 1, omega_n, 1);
  if (omega_t) spread(tangential, 1, of()->dims.nt, omega_t, 1);
  return code;
}

static int set_blocks(nsdae_system *made)
{
  const nsdae_blocks *v = &of()->blocks, *q = &of()->coordinates;
  int nq[WIDTH], nv[WIDTH];
  if (!of()->by_blocks) return NSDAE_OK;
  for (int b = 0; b < v->count; b++)
    nq[b] = nsdae_blocks_size(q, b), nv[b] = nsdae_blocks_size(v, b);
  return nsdae_system_set_blocks(made, v->count, nq, nv);
}

nsdae_system *spare_contacts_make(const spare_contacts *spare)
{
  const nsdae_system *from = spare->of;
  nsdae_dims dims = from->dims;
  nsdae_system *made;
  dims.k = spare_contacts_place(spare, dims.k);
  if (dims.k > SPARE_MOST || dims.nv > WIDTH || nsdae_system_create(&dims, &made, NULL) < 0)
    return NULL;
  at = spare;
  set_blocks(made);
  made->user = from->user;
  made->call = from->call;
  nsdae_system_set_gap(made, gap);
  if (from->call.gap_normal) nsdae_system_set_gap_normal(made, gap_normal);
  if (from->call.gap_tangent) nsdae_system_set_gap_tangent(made, gap_tangent);
  if (from->call.contact_bias) nsdae_system_set_contact_bias(made, contact_bias);
  if (from->call.contact_acceleration)
    nsdae_system_set_contact_acceleration(made, contact_acceleration);
  for (int i = 0; i < dims.k; i++) nsdae_system_set_contact(made, i, 0, 1, 0);
  for (int i = 0; i < from->dims.k; i++)
    made->contact[spare_contacts_place(spare, i)] = from->contact[i];
  memcpy(made->frictional_joint, from->frictional_joint,
         (size_t)dims.f * sizeof *made->frictional_joint);
  return made;
}
