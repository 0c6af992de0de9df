/* What a benchmark leaves for programs to read: build/bench.json, a list of {case, ours_us, peer,
 * peer_us, ratio}, ratio = peer_us / ours_us (above 1: ours is the faster). */
#ifndef NSDAE_BENCH_RATIO_H
#define NSDAE_BENCH_RATIO_H

#ifdef __cplusplus
extern "C" {
#endif

/* Adds an entry to the list in the file that NSDAE_BENCH_JSON names, which is a whole list after
 * each; nothing where it names none (a benchmark run by hand) or where a time is not finite and
 * positive: one of the two did not solve it. title: what was timed, other than in other calls;
 * ours, peers: medians, of the same work in the same run [s]. Returns 0, or -1: the file cannot be
 * written. */
int ratio_add(const char *title, double ours, const char *peer, double peers);

/* Processor time of this process so far [s]: that of all its threads. */
double ratio_cpu(void);

/* The median of so many numbers, which are sorted. */
double ratio_median(int count, double *a);

#ifdef __cplusplus
}
#endif
#endif
