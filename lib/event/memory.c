#include "memory.h"

#include <string.h>

void nsdae_event_memory_sizes(const nsdae_stepper *s, size_t *reals, size_t *wholes)
{
  const nsdae_dims *d = &s->system->dims;
  size_t kt = (size_t)d->k * (size_t)d->nt, forces = (size_t)d->k + kt, f = (size_t)d->f,
         m = (size_t)d->m;
  *reals = nsdae_contacts_warm_size(&s->contacts) + 3 + (size_t)d->nq + (size_t)d->nv + kt + f +
           forces * forces + m * m;
  *wholes = 2 * nsdae_contacts_memory_size(&s->contacts) + (size_t)d->k + 4 * f + 1 + forces + 5;
}

static double *reals_of(double **next, size_t count)
{
  double *at = *next;
  *next += count;
  return at;
}

static int *wholes_of(int **next, size_t count)
{
  int *at = *next;
  *next += count;
  return at;
}

void nsdae_event_lay(nsdae_event_base *b, nsdae_event_integrator *g, nsdae_event_instant *p,
                     nsdae_memory *memory)
{
  nsdae_event_modes *m = &p->roots->phase->modes;
  const nsdae_dims *d = &p->roots->phase->setting->system->dims;
  size_t k = (size_t)d->k, kt = k * (size_t)d->nt, f = (size_t)d->f;
  size_t warm = nsdae_contacts_memory_size(&p->impacts.problem);
  double *real = memory->real + p->roots->phase->setting->warm;
  int *whole = memory->whole;
  nsdae_contacts_remember(&p->impacts.problem, wholes_of(&whole, warm), NULL);
  nsdae_contacts_remember(&p->acceleration.problem, wholes_of(&whole, warm), NULL);
  m->contact = wholes_of(&whole, k);
  m->slide = wholes_of(&whole, f);
  m->slide_sense = wholes_of(&whole, f);
  m->normal_sense = wholes_of(&whole, f);
  m->slide_row = wholes_of(&whole, f);
  m->redundant = wholes_of(&whole, 1);
  m->related = wholes_of(&whole, k + kt);
  b->steps = wholes_of(&whole, 1);
  b->instants = wholes_of(&whole, 1);
  b->idle = wholes_of(&whole, 1);
  b->tiny = wholes_of(&whole, 1);
  g->is_stiff = wholes_of(&whole, 1);
  m->slide_part = reals_of(&real, f);
  m->relation = reals_of(&real, (k + kt) * (k + kt));
  m->range = reals_of(&real, (size_t)d->m * (size_t)d->m);
  b->t = reals_of(&real, 1);
  b->y = reals_of(&real, (size_t)d->nq + (size_t)d->nv);
  b->direction = reals_of(&real, kt);
  b->slow = reals_of(&real, 1);
  b->goal = reals_of(&real, 1);
}

void nsdae_event_save(nsdae_event_base *b, const nsdae_event_integrator *g, double t)
{
  const nsdae_event_phase *p = g->roots->phase;
  const nsdae_dims *d = &p->setting->system->dims;
  size_t n = (size_t)p->setting->at.lambda, kt = (size_t)d->k * (size_t)d->nt;
  *b->t = t;
  *b->steps = 0;
  *b->slow = p->modes.slow;
  memcpy(b->y, g->y, n * sizeof *b->y);
  memcpy(b->direction, p->modes.direction, kt * sizeof *b->direction);
}

void nsdae_event_restore(const nsdae_event_base *b, nsdae_event_integrator *g)
{
  nsdae_event_phase *p = g->roots->phase;
  const nsdae_dims *d = &p->setting->system->dims;
  size_t n = (size_t)p->setting->at.lambda, kt = (size_t)d->k * (size_t)d->nt;
  p->modes.slow = *b->slow;
  memcpy(g->y, b->y, n * sizeof *b->y);
  memcpy(p->modes.direction, b->direction, kt * sizeof *b->direction);
}
