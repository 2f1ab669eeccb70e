"""The commands as functions: samples to a field, a scan to a surface, a mesh to an audit.

Each function takes data in a file or in memory and returns a result, which draws itself, writes
files and makes a page. The commands of ``fieldrecon.cli`` call these functions with their options,
and print and write the result.
"""

from fieldrecon.pipelines.block_averages import block_means
from fieldrecon.pipelines.mesh_audits import AuditResult, audit
from fieldrecon.pipelines.samples import Samples
from fieldrecon.pipelines.scans import ScanResult, surface
from fieldrecon.pipelines.survey_results import Prediction, SurveyResult
from fieldrecon.pipelines.surveys import reconstruct

__all__ = [
    "AuditResult",
    "Prediction",
    "Samples",
    "ScanResult",
    "SurveyResult",
    "audit",
    "block_means",
    "reconstruct",
    "surface",
]
