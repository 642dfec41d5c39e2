"""What others would do on the same cases, with the same library, re-tune and data: the workflow is compared with each, in pairs."""
