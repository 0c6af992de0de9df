! nsdae/certificate.h: outcome and proof of a solve.
module nsdae_f_certificate
  use, intrinsic :: iso_c_binding
  use nsdae_f_text
  implicit none
  private

  ! Outcome of a solve.
  integer(c_int), parameter, public :: &
      NSDAE_OUTCOME_UNSOLVED = 0, &
      NSDAE_OUTCOME_SOLVED = 1, &
      NSDAE_OUTCOME_INFEASIBLE = 2

  ! Proofs of infeasibility.
  integer(c_int), parameter, public :: &
      NSDAE_PROOF_NONE = 0, &
      NSDAE_PROOF_FARKAS = 1, &
      NSDAE_PROOF_ENUMERATED = 2

  public :: nsdae_outcome_name, nsdae_proof_name

  interface
    type(c_ptr) function c_outcome_name(outcome) bind(C, name='nsdae_outcome_name')
      import
      integer(c_int), value :: outcome
    end function
    type(c_ptr) function c_proof_name(proof) bind(C, name='nsdae_proof_name')
      import
      integer(c_int), value :: proof
    end function
  end interface

contains

  function nsdae_outcome_name(outcome) result(text)
    integer(c_int), intent(in) :: outcome
    character(len=:), allocatable :: text
    text = from_c(c_outcome_name(outcome))
  end function

  function nsdae_proof_name(proof) result(text)
    integer(c_int), intent(in) :: proof
    character(len=:), allocatable :: text
    text = from_c(c_proof_name(proof))
  end function
end module
