/* Threads wait for a loop by spinning for some microseconds, as most loops of a step follow each
 * other closely, and then on a condition. The loop is one number, the passes that are not handed
 * out: a thread that finds none has nothing to do with the loop, so that no loop waits for a thread
 * that is late. */
#define _POSIX_C_SOURCE 200809L /* masks of signals */
#include "thread_pool.h"

#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>

#include "spin.h"

typedef struct member {
  nsdae_thread_pool *pool;
  int number;
  pthread_t thread;
} member;

struct nsdae_thread_pool {
  int size;
  member *hired; /* size - 1 */
  int threads;   /* of them, running */
  pthread_mutex_t lock;
  pthread_cond_t begin;
  atomic_int asleep, quit;
  int within; /* a loop is being done */
  /* the loop at hand */
  nsdae_thread_pool_pass *pass;
  void *shared;
  int count;
  atomic_int portion;
  atomic_int left;   /* passes that nobody has, the last ones */
  atomic_int done;   /* passes */
  atomic_int failed; /* least pass that failed; INT_MAX: none */
};

/* Looks for a loop before a thread sleeps: some 20 us. */
enum { LOOKS = 1000 };

/* The next portion, from `*from` on; 0: none is left. The loop does not end, and its fields do not
 * change, while a thread has a portion. */
static int take(nsdae_thread_pool *p, int *from)
{
  int left = atomic_load_explicit(&p->left, memory_order_acquire), count = 0;
  while (left > 0) {
    int portion = atomic_load_explicit(&p->portion, memory_order_relaxed);
    count = portion < left ? portion : left;
    if (atomic_compare_exchange_weak_explicit(&p->left, &left, left - count, memory_order_acq_rel,
                                              memory_order_acquire))
      break;
  }
  if (left == 0) return 0;
  *from = p->count - left;
  return count;
}

/* Portions until none is left. Passes after one that failed are not begun; those before it belong
 * to portions that were handed out already. */
static void do_passes(nsdae_thread_pool *p, int worker)
{
  int from, count;
  while ((count = take(p, &from)) > 0) {
    for (int i = from; i < from + count; i++) {
      if (i > atomic_load_explicit(&p->failed, memory_order_relaxed)) break;
      if (p->pass(p->shared, worker, i) < 0) { /* failed := min(failed, i) */
        int least = atomic_load(&p->failed);
        while (i < least && !atomic_compare_exchange_weak(&p->failed, &least, i)) continue;
      }
    }
    atomic_fetch_add_explicit(&p->done, count, memory_order_acq_rel);
  }
}

/* asleep is counted before left is read, and left is written before asleep is read: one of the two
 * threads sees the other. */
static void sleep_until_loop(nsdae_thread_pool *p)
{
  pthread_mutex_lock(&p->lock);
  atomic_fetch_add(&p->asleep, 1);
  while (atomic_load(&p->left) == 0 && !atomic_load(&p->quit))
    pthread_cond_wait(&p->begin, &p->lock);
  atomic_fetch_sub(&p->asleep, 1);
  pthread_mutex_unlock(&p->lock);
}

static void *live(void *object)
{
  member *me = object;
  nsdae_thread_pool *p = me->pool;
  while (!atomic_load(&p->quit)) {
    int looks = 0;
    while (looks < LOOKS && atomic_load_explicit(&p->left, memory_order_relaxed) == 0) {
      nsdae_spin_pause();
      looks++;
    }
    if (looks == LOOKS) sleep_until_loop(p);
    do_passes(p, me->number);
  }
  return NULL;
}

static void wake(nsdae_thread_pool *p)
{
  if (atomic_load(&p->asleep) == 0) return;
  pthread_mutex_lock(&p->lock);
  pthread_cond_broadcast(&p->begin);
  pthread_mutex_unlock(&p->lock);
}

static int hire(nsdae_thread_pool *p)
{
#ifndef _WIN32 /* signals stay with the threads of the program */
  sigset_t all, before;
  sigfillset(&all);
  pthread_sigmask(SIG_SETMASK, &all, &before);
#endif
  for (p->threads = 0; p->threads < p->size - 1; p->threads++) {
    member *m = &p->hired[p->threads];
    *m = (member){.pool = p, .number = p->threads + 1};
    if (pthread_create(&m->thread, NULL, live, m) != 0) break;
  }
#ifndef _WIN32
  pthread_sigmask(SIG_SETMASK, &before, NULL);
#endif
  return p->threads == p->size - 1;
}

nsdae_thread_pool *nsdae_thread_pool_make(int size)
{
  nsdae_thread_pool *p = calloc(1, sizeof *p);
  if (!p) return NULL;
  p->size = size;
  pthread_mutex_init(&p->lock, NULL);
  pthread_cond_init(&p->begin, NULL);
  p->hired = calloc((size_t)size, sizeof *p->hired);
  if (!p->hired || !hire(p)) {
    nsdae_thread_pool_release(p);
    return NULL;
  }
  return p;
}

void nsdae_thread_pool_release(nsdae_thread_pool *p)
{
  if (!p) return;
  atomic_store(&p->quit, 1);
  wake(p);
  for (int i = 0; i < p->threads; i++) pthread_join(p->hired[i].thread, NULL);
  pthread_cond_destroy(&p->begin);
  pthread_mutex_destroy(&p->lock);
  free(p->hired);
  free(p);
}

int nsdae_thread_pool_size(const nsdae_thread_pool *p)
{
  return p ? p->size : 1;
}

static void begin(nsdae_thread_pool *p, int count, int portion, nsdae_thread_pool_pass *pass,
                  void *shared)
{
  p->within = 1;
  p->pass = pass;
  p->shared = shared;
  p->count = count;
  atomic_store_explicit(&p->portion, portion, memory_order_relaxed);
  atomic_store_explicit(&p->failed, INT_MAX, memory_order_relaxed);
  atomic_store_explicit(&p->done, 0, memory_order_relaxed);
  atomic_store(&p->left, count);
  wake(p);
}

int nsdae_thread_pool_run(nsdae_thread_pool *p, int alone, int count, int portion,
                          nsdae_thread_pool_pass *pass, void *shared)
{
  if (!p || alone || p->size == 1 || count <= portion || p->within) {
    for (int i = 0; i < count; i++)
      if (pass(shared, 0, i) < 0) return i;
    return -1;
  }
  begin(p, count, portion, pass, shared);
  do_passes(p, 0);
  for (int spins = 0; atomic_load_explicit(&p->done, memory_order_acquire) < count;)
    nsdae_spin(&spins);
  p->within = 0;
  int failed = atomic_load(&p->failed);
  return failed == INT_MAX ? -1 : failed;
}

/* ---- ranges of items */

enum { RANGES = 256 };

typedef struct ranges {
  nsdae_thread_pool_range *range;
  nsdae_thread_pool_value *value;
  void *shared;
  int count, grain;
  double most[RANGES];
} ranges;

static int do_range(void *object, int worker, int i)
{
  ranges *r = object;
  int from = i * r->grain, to = r->count - from < r->grain ? r->count : from + r->grain;
  (void)worker;
  if (r->range)
    r->range(r->shared, from, to);
  else
    r->most[i] = r->value(r->shared, from, to);
  return 0;
}

static int do_ranges(nsdae_thread_pool *p, ranges *r)
{
  int least = (r->count - 1) / RANGES + 1;
  if (r->grain < least) r->grain = least;
  int count = (r->count - 1) / r->grain + 1;
  nsdae_thread_pool_run(p, 0, count, 1, do_range, r);
  return count;
}

void nsdae_thread_pool_for(nsdae_thread_pool *p, int count, int grain,
                           nsdae_thread_pool_range *range, void *shared)
{
  ranges all;
  all.range = range;
  all.shared = shared;
  all.count = count;
  all.grain = grain;
  if (count > 0 && (nsdae_thread_pool_size(p) == 1 || count <= grain))
    range(shared, 0, count);
  else if (count > 0)
    do_ranges(p, &all);
}

double nsdae_thread_pool_most(nsdae_thread_pool *p, int count, int grain,
                              nsdae_thread_pool_value *value, void *shared)
{
  ranges all = {.value = value, .shared = shared, .count = count, .grain = grain};
  double most = 0;
  int parts = count > 0 ? do_ranges(p, &all) : 0;
  for (int i = 0; i < parts && most == most; i++)
    if (!(all.most[i] <= most)) most = all.most[i];
  return most;
}
