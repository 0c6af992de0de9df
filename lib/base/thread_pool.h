/* Threads that share the passes of a loop, kept from one loop to the next: passes are handed out in
 * portions, in ascending order, to whoever is idle. Which thread does a pass is chance, so a pass
 * writes to places of its own alone, and what is summed over passes is of whole numbers or summed
 * afterwards. */
#ifndef NSDAE_BASE_CREW_H
#define NSDAE_BASE_CREW_H

typedef struct nsdae_thread_pool nsdae_thread_pool;

/* Pass i, by worker 0 .. size - 1; negative where it failed. */
typedef int nsdae_thread_pool_pass(void *shared, int worker, int i);

/* size workers, 1 or more: the thread that calls is one of them. NULL without memory or threads. */
nsdae_thread_pool *nsdae_thread_pool_make(int size);
/* May be NULL. */
void nsdae_thread_pool_release(nsdae_thread_pool *crew);

/* All passes 0 .. count - 1, on the whole crew or, with alone, on the thread that calls. Returns
 * -1, or the least pass that failed: those before it are done, no worker begins one after its own
 * that failed. */
int nsdae_thread_pool_run(nsdae_thread_pool *crew, int alone, int count, int portion,
                          nsdae_thread_pool_pass *pass, void *shared);

#endif
