/* Threads that share the passes of a loop, kept from one loop to the next. Passes are handed out in
 * portions, in ascending order, to any idle thread. The order between threads is not fixed: a pass
 * writes to places of its own alone, and sums over passes are of whole numbers or are done
 * afterwards. */
#ifndef NSDAE_BASE_THREAD_POOL_H
#define NSDAE_BASE_THREAD_POOL_H

typedef struct nsdae_thread_pool nsdae_thread_pool;

/* Pass i, by worker 0 .. size - 1; negative if it failed. */
typedef int nsdae_thread_pool_pass(void *shared, int worker, int i);

/* size workers, 1 or more: the thread that calls is one of them. NULL without memory or threads. */
nsdae_thread_pool *nsdae_thread_pool_make(int size);
/* May be NULL. */
void nsdae_thread_pool_release(nsdae_thread_pool *pool);

/* Its workers; NULL: 1. */
int nsdae_thread_pool_size(const nsdae_thread_pool *pool);

/* All passes 0 .. count - 1, on the whole pool or, with alone, on the thread that calls; so also
 * without a pool, and within a pass. Returns -1, or the least pass that failed: those before it are
 * done, no worker begins one after its own that failed. */
int nsdae_thread_pool_run(nsdae_thread_pool *pool, int alone, int count, int portion,
                          nsdae_thread_pool_pass *pass, void *shared);

/* Items from .. to - 1 of a loop that cannot fail. */
typedef void nsdae_thread_pool_range(void *shared, int from, int to);

/* All items 0 .. count - 1, in ranges of `grain` items. */
void nsdae_thread_pool_for(nsdae_thread_pool *pool, int count, int grain,
                           nsdae_thread_pool_range *range, void *shared);

/* The largest of what the ranges return, and of 0; NaN if one of them is. */
typedef double nsdae_thread_pool_value(void *shared, int from, int to);
double nsdae_thread_pool_most(nsdae_thread_pool *pool, int count, int grain,
                              nsdae_thread_pool_value *value, void *shared);

#endif
