"""The pages of the site in pages/, and the scripts that write parts of them: python -m docs.NAME"""
