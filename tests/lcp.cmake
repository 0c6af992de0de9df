nsdae_unit_test(lcp lemke)
target_sources(test_unit_lcp_lemke PRIVATE bench/lcp_families.c)
