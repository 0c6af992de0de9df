/* Current run of each rank of this machine, in shared memory. If a rank is killed, the others
 * report its run. */
#ifndef NSDAE_SWEEP_PLACES_H
#define NSDAE_SWEEP_PLACES_H

/* Made by all ranks together, after MPI_Init; released before MPI_Finalize. */
void places_share(int rank);
void places_release(void);

/* This rank is in a run (what: "r=0.01"), or between two. */
void places_begin(long run, const char *what);
void places_end(void);
/* This rank has finished: its end is no failure. */
void places_leave(void);

/* Installs a handler of SIGTERM, which mpirun sends to the other ranks when one is killed. One of
 * them reports the killed rank and its run; then the former handler runs. To be called again after
 * another handler was set. */
void places_watch(void);

#endif
