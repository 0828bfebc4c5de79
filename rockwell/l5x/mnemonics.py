"""Names of all instructions of Logix controllers, including those that scanrack lacks.

In a partial export, any other name is an add-on instruction whose definition is missing.
"""

from __future__ import annotations

from scanrack.ladder.instructions import BY_NAME

OWN = frozenset({"ASSERT"})
"""Instructions that scanrack has but no controller has."""

MNEMONICS = frozenset(BY_NAME) - OWN | frozenset(
    """
    ASO AVC BAND BNOT BOR BXOR CBCM CBIM CBSSM CC CEM CPM CSM DCA DCAF DCM DCSRT DCST DCSTL DCSTM DIN DLG
    ENPEN EPMS ESTOP FIVPEN FPMS FSBM HIBC IMC JXR LC MAX MIN MMC MMVC MUX MVC MVMT RIN ROUT SMAT THRS THRSE
    TOTL TSAM TSSM
    """.split()  # noqa: SIM905 - a table of names
)
"""Names in capitals: supported instructions, and others [1756-RM003, 1756-RM006, MOTION-RM002]."""
