/* What each rank of this machine does, in memory that they share: when one of them is killed, the
 * others can say in which run that was. */
#ifndef NSDAE_SWEEP_PLACES_H
#define NSDAE_SWEEP_PLACES_H

/* Made by all ranks together, after MPI_Init; released before MPI_Finalize. */
void places_share(int rank);
void places_release(void);

/* This rank is in a run (what: "r=0.01"), or between two. */
void places_begin(long run, const char *what);
void places_end(void);
/* This rank is done, and its end is not a death. */
void places_leave(void);

/* From here on SIGTERM, which mpirun sends to the others when one is killed, has one of those that
 * are left write who is gone and at what, at once, whatever it waits for; then comes the handler
 * that was there. To be called again when another handler was set. */
void places_watch(void);

#endif
