/* Names of outcomes and proofs. */
#include <nsdae/certificate.h>

const char *nsdae_outcome_name(int outcome)
{
  static const char *const name[] = {"unsolved", "solved", "infeasible"};
  return outcome >= 0 && outcome <= NSDAE_OUTCOME_INFEASIBLE ? name[outcome] : "unknown";
}

const char *nsdae_proof_name(int proof)
{
  static const char *const name[] = {"none", "farkas", "enumerated"};
  return proof >= 0 && proof <= NSDAE_PROOF_ENUMERATED ? name[proof] : "unknown";
}
