#define _POSIX_C_SOURCE 200809L /* masks of signals */
#include "thread_pool.h"

#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>

typedef struct member {
  nsdae_thread_pool *crew;
  int number;
  pthread_t thread;
} member;

struct nsdae_thread_pool {
  int size;
  member *hired; /* size - 1 */
  int threads;   /* of them, running */
  pthread_mutex_t lock;
  pthread_cond_t begin, end;
  unsigned long round; /* how many loops were begun */
  int busy, quit;
  /* the loop at hand */
  nsdae_thread_pool_pass *pass;
  void *shared;
  int count, portion;
  atomic_int next;   /* first pass that nobody has */
  atomic_int failed; /* least pass that failed; INT_MAX: none */
};

/* Portions until none is left. Passes after one that failed are not begun; those before it belong
 * to portions that were handed out already. */
static void work(nsdae_thread_pool *c, int worker)
{
  for (;;) {
    int from = atomic_fetch_add(&c->next, c->portion);
    int to = c->count - from < c->portion ? c->count : from + c->portion;
    if (from >= c->count) return;
    for (int i = from; i < to; i++) {
      if (i > atomic_load_explicit(&c->failed, memory_order_relaxed)) return;
      if (c->pass(c->shared, worker, i) < 0) { /* failed := min(failed, i) */
        int least = atomic_load(&c->failed);
        while (i < least && !atomic_compare_exchange_weak(&c->failed, &least, i)) continue;
      }
    }
  }
}

static void *live(void *object)
{
  member *me = object;
  nsdae_thread_pool *c = me->crew;
  unsigned long seen = 0;
  pthread_mutex_lock(&c->lock);
  for (;;) {
    while (c->round == seen && !c->quit) pthread_cond_wait(&c->begin, &c->lock);
    if (c->quit) break;
    seen = c->round;
    pthread_mutex_unlock(&c->lock);
    work(c, me->number);
    pthread_mutex_lock(&c->lock);
    if (--c->busy == 0) pthread_cond_signal(&c->end);
  }
  pthread_mutex_unlock(&c->lock);
  return NULL;
}

/* Signals stay with the threads of the program. */
static int hire(nsdae_thread_pool *c)
{
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
  for (c->threads = 0; c->threads < c->size - 1; c->threads++) {
    member *m = &c->hired[c->threads];
    *m = (member){.crew = c, .number = c->threads + 1};
    if (pthread_create(&m->thread, NULL, live, m) != 0) break;
  }
  pthread_sigmask(SIG_SETMASK, &before, NULL);
  return c->threads == c->size - 1;
}

nsdae_thread_pool *nsdae_thread_pool_make(int size)
{
  nsdae_thread_pool *c = calloc(1, sizeof *c);
  if (!c) return NULL;
  c->size = size;
  pthread_mutex_init(&c->lock, NULL);
  pthread_cond_init(&c->begin, NULL);
  pthread_cond_init(&c->end, NULL);
  c->hired = calloc((size_t)size, sizeof *c->hired);
  if (!c->hired || !hire(c)) {
    nsdae_thread_pool_release(c);
    return NULL;
  }
  return c;
}

void nsdae_thread_pool_release(nsdae_thread_pool *c)
{
  if (!c) return;
  pthread_mutex_lock(&c->lock);
  c->quit = 1;
  pthread_cond_broadcast(&c->begin);
  pthread_mutex_unlock(&c->lock);
  for (int i = 0; i < c->threads; i++) pthread_join(c->hired[i].thread, NULL);
  pthread_cond_destroy(&c->begin);
  pthread_cond_destroy(&c->end);
  pthread_mutex_destroy(&c->lock);
  free(c->hired);
  free(c);
}

/* All threads learn of the loop under the lock, and nobody leaves it before all are done. */
int nsdae_thread_pool_run(nsdae_thread_pool *c, int alone, int count, int portion,
                          nsdae_thread_pool_pass *pass, void *shared)
{
  if (alone || c->size == 1 || count <= portion) {
    for (int i = 0; i < count; i++)
      if (pass(shared, 0, i) < 0) return i;
    return -1;
  }
  pthread_mutex_lock(&c->lock);
  c->pass = pass;
  c->shared = shared;
  c->count = count;
  c->portion = portion;
  atomic_store(&c->next, 0);
  atomic_store(&c->failed, INT_MAX);
  c->busy = c->threads;
  c->round++;
  pthread_cond_broadcast(&c->begin);
  pthread_mutex_unlock(&c->lock);
  work(c, 0);
  pthread_mutex_lock(&c->lock);
  while (c->busy > 0) pthread_cond_wait(&c->end, &c->lock);
  pthread_mutex_unlock(&c->lock);
  int failed = atomic_load(&c->failed);
  return failed == INT_MAX ? -1 : failed;
}
