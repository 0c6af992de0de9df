! nsdae/certificate.h: outcome and proof of a solve.
module nsdae_f_certificate
  use, intrinsic :: iso_c_binding
  use nsdae_f_text
  implicit none
  private

  ! What is known of a problem after the chain.
  ! headers: constants NSDAE_OUTCOME_

  ! What proves that there is no solution.
  ! headers: constants NSDAE_PROOF_

  public :: nsdae_outcome_name, nsdae_proof_name

  interface
    ! headers: functions nsdae_ outcome_name proof_name
  end interface

contains

  ! headers: wrappers nsdae_ outcome_name proof_name
end module
