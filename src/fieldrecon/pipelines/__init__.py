"""The commands as functions: samples to a field, a scan to a surface, a mesh to an audit.

Each function takes a request and returns a result, both frozen dataclasses. The commands of
``fieldrecon.cli`` make the request of their options, and print and write the result.
"""

from fieldrecon.pipelines.audit import AuditRequest, AuditResult, audit_file
from fieldrecon.pipelines.block_averages import block_means
from fieldrecon.pipelines.reconstruct import SurveyRequest, SurveyResult, reconstruct_survey
from fieldrecon.pipelines.samples import Samples, read_samples
from fieldrecon.pipelines.surface import ScanRequest, ScanResult, reconstruct_scan

__all__ = [
    "AuditRequest",
    "AuditResult",
    "Samples",
    "ScanRequest",
    "ScanResult",
    "SurveyRequest",
    "SurveyResult",
    "audit_file",
    "block_means",
    "read_samples",
    "reconstruct_scan",
    "reconstruct_survey",
]
