# Tests of the complementarity problems: kernels, solver, published problems, seeded families.
nsdae_test(anomaly lcp LINKS test_allocator)
