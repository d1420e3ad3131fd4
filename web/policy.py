"""Content-Security-Policy of the page: own files, and the Inverse Service of this machine, nothing else."""

INVERSE_SERVICE = "ws://127.0.0.1:10001 ws://localhost:10001"


def policy(in_page: bool = False) -> str:
    """The policy's text. `in_page`: without what a <meta> element cannot say."""
    rules = [
        "default-src 'none'",
        "script-src 'self' 'wasm-unsafe-eval'",
        "worker-src 'self'",
        f"connect-src 'self' {INVERSE_SERVICE}",
        "style-src 'self'",
        "img-src 'self'",
        "base-uri 'none'",
        "form-action 'none'",
    ]
    if not in_page:
        rules.append("frame-ancestors 'none'")
    return "; ".join(rules)
